/* A line fitted to the measurements of the last hour: each new row is added, and the row of an hour
 * ago is removed. */

#include <catamaran.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { MINUTES = 600, WINDOW = 60 };

static void check(cata_status status)
{
    if (status != CATA_OK) {
        fprintf(stderr, "%s: %s\n", cata_status_name(status), cata_last_error_message());
        exit(EXIT_FAILURE);
    }
}

/* The slope turns from 1 to -2 after five hours. */
static void measure(int minute, double row[3])
{
    const double t = minute / 60.0;
    row[0] = 1;
    row[1] = t;
    row[2] = (t < 5 ? t : 15 - 2 * t) + 0.01 * sin(17.0 * minute);
}

int main(void)
{
    const double lower[3] = {1, 0, -10}, upper[3] = {1, 10, 10};
    cata_accumulator_params params = {.struct_size = sizeof params,
                                      .sums = CATA_SUMS_EXTENDED,
                                      .lower = lower,
                                      .upper = upper,
                                      .rows = MINUTES};
    cata_accumulator *window;
    check(cata_accumulator_new(3, &params, &window));
    double row[3], fit[2] = {0}, worst = 0;
    for (int minute = 0; minute < MINUTES; minute++) {
        measure(minute, row);
        check(cata_accumulator_add(window, CATA_ROW_MAJOR, 1, row, 3, NULL));
        if (minute >= WINDOW) {
            measure(minute - WINDOW, row);
            check(cata_accumulator_remove(window, CATA_ROW_MAJOR, 1, row, 3, NULL));
        }
        if (minute % 120 == 119) {
            check(cata_accumulator_lstsq(window, 1, CATA_ROW_MAJOR, fit, 1, NULL, NULL));
            printf("after %2d hours: %.2f + %.2f t\n", (minute + 1) / 60, fit[0], fit[1]);
            worst = fmax(worst, fabs(fit[1] - (minute < 300 ? 1 : -2)));
        }
    }
    cata_accumulator_free(window);
    printf("slopes are right to %.3f\n", worst);
    return worst < 0.05 ? EXIT_SUCCESS : EXIT_FAILURE;
}
