! Prints A^T A of the columns (1, 3, 5) and (2, 4, 6).
program stranger
  use catamaran
  implicit none
  real(c_double) :: a(3, 2), c(2, 2)
  a = reshape([1.0_c_double, 3.0_c_double, 5.0_c_double, 2.0_c_double, 4.0_c_double, &
               6.0_c_double], [3, 2])
  if (cata_ata_f64(CATA_COL_MAJOR, CATA_BOTH, 3_c_size_t, 2_c_size_t, 1.0_c_double, a, &
                   3_c_size_t, 0.0_c_double, c, 2_c_size_t) /= CATA_OK) error stop
  print '(i0, 3(1x, i0))', nint(c)
end program stranger
