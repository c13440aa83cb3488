#include <catamaran.h>

#include <stdio.h>

int main(void)
{
    const double a[6] = {1, 2, 3, 4, 5, 6}; /* 3 x 2 */
    double c[4];
    if (cata_ata_f64(CATA_ROW_MAJOR, CATA_BOTH, 3, 2, 1.0, a, 2, 0.0, c, 2, NULL) != CATA_OK) {
        fprintf(stderr, "%s\n", cata_last_error_message());
        return 1;
    }
    printf("%g %g %g %g\n", c[0], c[1], c[2], c[3]);
    return !(c[0] == 35 && c[1] == 44 && c[2] == 44 && c[3] == 56);
}
