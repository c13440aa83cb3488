/* The spatial covariance of an antenna array: A^H A of complex samples, and A^H B with the response
 * to a direction, checked against plain loops. */

#include <catamaran.h>

#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SAMPLES = 2000, ANTENNAS = 6 };

static const double TAU = 6.283185307179586;

/* Antennas half a wavelength apart see a plane wave with this step of phase, and noise. */
static void fill(double complex *samples, double step)
{
    unsigned state = 12345;
    for (int i = 0; i < SAMPLES; i++) {
        for (int j = 0; j < ANTENNAS; j++) {
            double noise[2];
            for (int part = 0; part < 2; part++) {
                state = state * 1664525u + 1013904223u;
                noise[part] = (double)(state >> 8) / 16777216.0 - 0.5;
            }
            samples[i * ANTENNAS + j] =
                cexp(I * (0.1 * TAU * i + step * j)) + 0.2 * (noise[0] + I * noise[1]);
        }
    }
}

int main(void)
{
    double complex *samples = malloc(sizeof *samples * SAMPLES * ANTENNAS);
    double complex covariance[ANTENNAS * ANTENNAS], response[ANTENNAS], filtered[ANTENNAS];
    if (samples == NULL) {
        fputs("out of memory\n", stderr);
        return EXIT_FAILURE;
    }
    const double step = 0.7;
    fill(samples, step);
    for (int j = 0; j < ANTENNAS; j++) {
        /* Conjugated, because A^H A has the conjugates on its left. */
        response[j] = cexp(-I * step * j) / sqrt(ANTENNAS);
    }

    /* double complex is a pair of doubles: the pointers are cast, and lda counts pairs. */
    cata_status status = cata_aha_c64(CATA_ROW_MAJOR, CATA_BOTH, SAMPLES, ANTENNAS, 1.0 / SAMPLES,
                                      (const double *)samples, ANTENNAS, 0.0, (double *)covariance,
                                      ANTENNAS, NULL);
    const double complex one = 1.0, zero = 0.0;
    if (status == CATA_OK) {
        /* Covariance times the response; the covariance is its own conjugate transpose. */
        status = cata_ahb_c64(CATA_ROW_MAJOR, ANTENNAS, ANTENNAS, 1, (const double *)&one,
                              (const double *)covariance, ANTENNAS, (const double *)response, 1,
                              (const double *)&zero, (double *)filtered, 1, NULL);
    }
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        free(samples);
        return EXIT_FAILURE;
    }

    double worst = 0.0, power = 0.0;
    int hermitian = 1;
    for (int j = 0; j < ANTENNAS; j++) {
        double complex product = 0.0;
        for (int k = 0; k < ANTENNAS; k++) {
            double complex sum = 0.0;
            for (int i = 0; i < SAMPLES; i++) {
                sum += conj(samples[i * ANTENNAS + j]) * samples[i * ANTENNAS + k] / SAMPLES;
            }
            const double complex entry = covariance[j * ANTENNAS + k];
            worst = fmax(worst, cabs(entry - sum));
            product += entry * response[k];
            hermitian = hermitian && entry == conj(covariance[k * ANTENNAS + j]);
        }
        worst = fmax(worst, cabs(filtered[j] - product));
        power += creal(conj(response[j]) * filtered[j]);
    }
    free(samples);
    printf("power from the direction of the wave: %.4f, of all: ", power);
    double total = 0.0;
    for (int j = 0; j < ANTENNAS; j++) {
        total += creal(covariance[j * ANTENNAS + j]);
    }
    printf("%.4f\nlargest difference from the plain loops: %.1e\n", total, worst);
    if (!(worst < 1e-12) || !hermitian || !(power > 0.95 * total)) {
        fputs("MISMATCH\n", stderr);
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
