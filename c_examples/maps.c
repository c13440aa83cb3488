/* A map between two closed curves that are numbered differently, fitted to three landmarks and refined; a function is
 * carried over through products, and smoothed. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { N = 120, FEW = 5, ALL = 13, SHIFT = 17 };

static double masses[N], values[ALL], first[ALL * N], second[ALL * N];

static void checked(cata_status status)
{
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        exit(EXIT_FAILURE);
    }
}

/* The point of the first curve for a point of the second. */
static int image(int i)
{
    return (i + SHIFT) % N;
}

/* Eigenfunctions of a circle: the constant, cosines and sines. */
static double eigenfunction(int j, int i)
{
    const double at = (j + 1) / 2 * 2 * acos(-1) * i / N;
    return j == 0 ? 1 : sqrt(2) * (j % 2 ? cos(at) : sin(at));
}

int main(void)
{
    for (int j = 0; j < ALL; j++) {
        values[j] = (double)((j + 1) / 2) * ((j + 1) / 2);
        for (int i = 0; i < N; i++) {
            masses[i] = 1.0 / N;
            first[j * N + i] = eigenfunction(j, i);
            second[j * N + i] = eigenfunction(j, image(i));
        }
    }
    cata_basis *few = NULL, *few_second = NULL, *all = NULL, *all_second = NULL;
    checked(cata_basis_new(N, FEW, masses, values, first, N, NULL, &few));
    checked(cata_basis_new(N, FEW, masses, values, second, N, NULL, &few_second));
    checked(cata_basis_new(N, ALL, masses, values, first, N, NULL, &all));
    checked(cata_basis_new(N, ALL, masses, values, second, N, NULL, &all_second));

    /* From three landmarks to the map of the few functions, and from that to all functions and points. */
    const uint32_t pairs[6] = {SHIFT, 0, SHIFT + 10, 10, SHIFT + 50, 50};
    double c[FEW * FEW], map[ALL * ALL];
    uint32_t points[N];
    cata_map_fit *fit = NULL;
    checked(cata_map_fit_new(few, few_second, &fit));
    checked(cata_map_fit_landmarks(fit, 3, pairs));
    checked(cata_map_fit_solve(fit, 1e-3, CATA_ROW_MAJOR, c, FEW, NULL));
    checked(cata_map_zoomout(all, all_second, 2, CATA_ROW_MAJOR, FEW, FEW, c, FEW, map, ALL, points, NULL));
    int wrong = 0;
    for (int i = 0; i < N; i++) {
        wrong += points[i] != (uint32_t)image(i);
    }

    /* cos(9 x) is a product of eigenfunctions, but none of the thirteen. Heat takes exp(-t) of cos(x). */
    double f[N], g[N], smooth[N], gains[ALL], gap = 0, left = 0;
    for (int i = 0; i < N; i++) {
        f[i] = cos(2 * acos(-1) * i / N) + cos(9 * 2 * acos(-1) * i / N);
    }
    checked(cata_transfer(all, all_second, points, CATA_COL_MAJOR, 1, f, N, g, N, NULL));
    for (int j = 0; j < ALL; j++) {
        gains[j] = exp(-0.5 * values[j]);
    }
    checked(cata_basis_filter(all, CATA_COL_MAJOR, 1, f, N, gains, 0, smooth, N));
    for (int i = 0; i < N; i++) {
        gap = fmax(gap, fabs(g[i] - f[image(i)]));
        left = fmax(left, fabs(smooth[i] - exp(-0.5) * cos(2 * acos(-1) * i / N)));
    }
    printf("%d of %d points wrong; carried over up to %.1e, smoothed up to %.1e\n", wrong, N, gap, left);
    cata_map_fit_free(fit);
    cata_basis_free(few);
    cata_basis_free(few_second);
    cata_basis_free(all);
    cata_basis_free(all_second);
    const int good = wrong == 0 && gap < 1e-9 && left < 1e-12;
    if (!good) {
        fprintf(stderr, "MISMATCH\n");
    }
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
