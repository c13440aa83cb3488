/* The spectrum of the union of two rectangles that overlap, from the spectra of the two. */

#include <catamaran.h>

#include <stdio.h>
#include <stdlib.h>

enum { K = CATA_UNION_EIGENVALUES, MODES = 24 };

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Of a rectangle with sides `width` and 1: pi^2 (i^2 / width^2 + j^2). */
static void rectangle(double width, double spectrum[K])
{
    static double all[MODES * MODES];
    const double pi = 3.14159265358979323846;
    for (int i = 0; i < MODES; i++) {
        for (int j = 0; j < MODES; j++) {
            double x = (i + 1) / width, y = j + 1;
            all[i * MODES + j] = pi * pi * (x * x + y * y);
        }
    }
    qsort(all, MODES * MODES, sizeof all[0], ascending);
    for (int i = 0; i < K; i++) {
        spectrum[i] = all[i];
    }
}

int main(void)
{
    double parts[2 * K], spectrum[K], ood_score = 0;
    rectangle(1.6, parts);
    rectangle(1.4, parts + K);
    cata_unions *unions = NULL;
    cata_status status = cata_unions_new(NULL, &unions);
    if (status == CATA_OK) {
        status = cata_unions_predict(unions, 2, parts, spectrum, &ood_score);
    }
    cata_unions_free(unions);
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        return EXIT_FAILURE;
    }
    printf("out-of-distribution score %.2f%s\n", ood_score, ood_score > 1 ? ": unreliable" : "");
    for (int i = 0; i < K; i++) {
        printf("%2d %9.3f %9.3f -> %9.3f\n", i + 1, parts[i], parts[K + i], spectrum[i]);
        int right = spectrum[i] > 0 && spectrum[i] <= parts[i] && spectrum[i] <= parts[K + i]
                 && (i == 0 || spectrum[i - 1] <= spectrum[i]);
        if (!right) {
            fputs("MISMATCH\n", stderr);
            return EXIT_FAILURE;
        }
    }
    return EXIT_SUCCESS;
}
