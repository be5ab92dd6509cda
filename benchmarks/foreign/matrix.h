/* The matrix that mpm-benchmarks writes, the clock, and the error of a solution. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* Lower triangle by columns, the diagonal first; the same arrays are the upper triangle by rows. */
struct matrix {
    int64_t n, entries;
    int64_t *start, *row;
    double *value, *rhs;
};

static void *take(FILE *file, size_t count) {
    void *data = malloc(8 * count);
    if (!data || fread(data, 8, count, file) != count) {
        fprintf(stderr, "the matrix file is too short\n");
        exit(1);
    }
    return data;
}

static struct matrix read_matrix(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file) {
        fprintf(stderr, "%s cannot be read\n", path);
        exit(1);
    }
    struct matrix m;
    int64_t *sizes = take(file, 2);
    m.n = sizes[0];
    m.entries = sizes[1];
    m.start = take(file, m.n + 1);
    m.row = take(file, m.entries);
    m.value = take(file, m.entries);
    m.rhs = take(file, m.n);
    fclose(file);
    return m;
}

static double processor_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

/* Largest residual over the largest right-hand side. */
static double error_of(const struct matrix *m, const double *x) {
    double *r = malloc(8 * m->n), worst = 0, size = 0;
    for (int64_t i = 0; i < m->n; i++) r[i] = m->rhs[i];
    for (int64_t j = 0; j < m->n; j++)
        for (int64_t k = m->start[j]; k < m->start[j + 1]; k++) {
            int64_t i = m->row[k];
            r[i] -= m->value[k] * x[j];
            if (i != j) r[j] -= m->value[k] * x[i];
        }
    for (int64_t i = 0; i < m->n; i++) {
        worst = fmax(worst, fabs(r[i]));
        size = fmax(size, fabs(m->rhs[i]));
    }
    free(r);
    return worst / size;
}

static void tell(double analyse, double factorise, double solve, double error) {
    printf("{\"analyse\": %.9f, \"factorise\": %.9f, \"solve\": %.9f, \"error\": %.3e}\n", analyse, factorise, solve, error);
}
