/* One call of cata_ata_f64 on a square matrix, for scripts/cache-misses:
 *
 *     cache_misses N SCHEME LEAF
 *
 * SCHEME is a value of CATA_SCHEME_*, LEAF the smallest side of a block (0: the library's choice).
 */
#include <catamaran.h>
#include <stdio.h>
#include <stdlib.h>

int main(int argc, char **argv)
{
    if (argc != 4) {
        fprintf(stderr, "usage: cache_misses N SCHEME LEAF\n");
        return 2;
    }
    size_t n = strtoul(argv[1], NULL, 10);
    cata_ata_params params;
    cata_ata_params_init(&params, sizeof params);
    params.scheme = atoi(argv[2]);
    params.leaf = strtoul(argv[3], NULL, 10);
    params.threads = 1;
    double *a = malloc(n * n * sizeof *a), *c = malloc(n * n * sizeof *c);
    if (!a || !c) {
        fprintf(stderr, "out of memory\n");
        return 1;
    }
    unsigned state = 1;
    for (size_t i = 0; i < n * n; ++i) {
        state = state * 1664525U + 1013904223U;
        a[i] = state / 2147483648.0 - 1;
    }
    if (cata_ata_f64(CATA_ROW_MAJOR, CATA_LOWER, n, n, 1, a, n, 0, c, n, &params) != CATA_OK) {
        fprintf(stderr, "%s\n", cata_last_error_message());
        return 1;
    }
    printf("%.17g\n", c[n * n - 1]);
    free(a);
    free(c);
    return 0;
}
