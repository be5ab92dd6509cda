/* cholmod MATRIX (amd | metis): CHOLMOD's supernodal factorisation, order and analysis included. */
#include "matrix.h"
#include <string.h>
#include <suitesparse/cholmod.h>

int main(int argc, char **argv) {
    if (argc != 3) return 2;
    struct matrix m = read_matrix(argv[1]);
    cholmod_common c;
    cholmod_l_start(&c);
    c.supernodal = CHOLMOD_SUPERNODAL;
    c.nmethods = 1;
    c.method[0].ordering = strcmp(argv[2], "amd") == 0 ? CHOLMOD_AMD : CHOLMOD_METIS;
    c.postorder = 1;

    cholmod_sparse a = {0};
    a.nrow = a.ncol = m.n;
    a.nzmax = m.entries;
    a.p = m.start;
    a.i = m.row;
    a.x = m.value;
    a.stype = -1;
    a.itype = CHOLMOD_LONG;
    a.xtype = CHOLMOD_REAL;
    a.dtype = CHOLMOD_DOUBLE;
    a.sorted = a.packed = 1;
    cholmod_dense b = {0};
    b.nrow = b.d = b.nzmax = m.n;
    b.ncol = 1;
    b.x = m.rhs;
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;

    double t0 = processor_seconds();
    cholmod_factor *l = cholmod_l_analyze(&a, &c);
    double t1 = processor_seconds();
    cholmod_l_factorize(&a, l, &c);
    double t2 = processor_seconds();
    if (c.status != CHOLMOD_OK) {
        fprintf(stderr, "CHOLMOD ends with status %d\n", c.status);
        return 1;
    }
    cholmod_dense *x = cholmod_l_solve(CHOLMOD_A, l, &b, &c);
    double t3 = processor_seconds();
    tell(t1 - t0, t2 - t1, t3 - t2, error_of(&m, x->x));
    return 0;
}
