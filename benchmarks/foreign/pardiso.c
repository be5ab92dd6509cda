/* pardiso MATRIX LIBRARY: MKL's PARDISO for positive definite matrices; LIBRARY is the path of libmkl_rt. */
#include "matrix.h"
#include <dlfcn.h>

typedef void solver(void *, const int64_t *, const int64_t *, const int64_t *, const int64_t *, const int64_t *,
                    const double *, const int64_t *, const int64_t *, int64_t *, const int64_t *, int64_t *,
                    const int64_t *, double *, double *, int64_t *);

int main(int argc, char **argv) {
    if (argc != 3) return 2;
    struct matrix m = read_matrix(argv[1]);
    void *library = dlopen(argv[2], RTLD_NOW | RTLD_GLOBAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    solver *pardiso = (solver *)dlsym(library, "pardiso_64");
    if (!pardiso) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    int64_t handle[64] = {0}, iparm[64] = {0}, one = 1, type = 2, quiet = 0, error = 0;
    iparm[0] = 1;  /* what follows is set, not defaulted */
    iparm[1] = 2;  /* METIS */
    iparm[34] = 1; /* indices from 0 */
    double *x = malloc(8 * m.n), t[4];
    t[0] = processor_seconds();
    for (int step = 0; step < 3; step++) {
        int64_t phase = 11 * (step + 1);
        pardiso(handle, &one, &one, &type, &phase, &m.n, m.value, m.start, m.row, NULL, &one, iparm, &quiet, m.rhs,
                x, &error);
        if (error) {
            fprintf(stderr, "PARDISO ends phase %d with %d\n", (int)phase, (int)error);
            return 1;
        }
        t[step + 1] = processor_seconds();
    }
    tell(t[1] - t[0], t[2] - t[1], t[3] - t[2], error_of(&m, x));
    return 0;
}
