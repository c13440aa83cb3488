! From Fortran: a product, least squares with standard errors, a sparse factorization and eigenpairs
! of a path, and the water of a plant; each is checked.
program example
  use catamaran
  implicit none
  call products()
  call squares()
  call factorization()
  call eigenpairs()
  call water()

contains

  subroutine check(status)
    integer(c_int32_t), intent(in) :: status
    if (status /= CATA_OK) then
      print '(a)', cata_message()
      error stop
    end if
  end subroutine check

  subroutine require(condition, what)
    logical, intent(in) :: condition
    character(*), intent(in) :: what
    if (.not. condition) error stop what
  end subroutine require

  subroutine products()
    integer(c_size_t), parameter :: m = 150, n = 40
    real(c_double) :: a(m, n), c(n, n)
    type(cata_ata_params) :: params
    integer(c_int32_t) :: status
    call random_number(a)
    call check(cata_ata_f64(CATA_COL_MAJOR, CATA_BOTH, m, n, 1.0_c_double, a, m, 0.0_c_double, c, &
                            n))
    params%struct_size = c_sizeof(params)
    params%error_factor = 1
    call check(cata_ata_f64(CATA_COL_MAJOR, CATA_BOTH, m, n, -1.0_c_double, a, m, 1.0_c_double, c, &
                            n, params))
    call require(maxval(abs(c)) < 1e-10_c_double, 'A^T A - A^T A is not 0')
    status = cata_ata_f64(CATA_COL_MAJOR, CATA_BOTH, m, n, 1.0_c_double, a, 1_c_size_t, &
                          0.0_c_double, c, n)
    call require(status == CATA_ERR_SHAPE .and. index(cata_message(), 'lda') > 0, 'lda was taken')
    print '(a, es8.1)', 'A^T A less itself: ', maxval(abs(c))
  end subroutine products

  ! b = 1 + 2 t, with an intercept.
  subroutine squares()
    real(c_double) :: t(4, 1), b(4), x(1)
    real(c_double), target :: intercept(1), errors(1)
    type(cata_lstsq_params) :: params
    type(cata_lstsq_result) :: found
    t(:, 1) = [0, 1, 2, 3]
    b = 1 + 2 * t(:, 1)
    params%struct_size = c_sizeof(params)
    params%intercept = 1
    found%struct_size = c_sizeof(found)
    found%intercepts = c_loc(intercept)
    found%standard_errors = c_loc(errors)
    call check(cata_lstsq(CATA_COL_MAJOR, 4_c_size_t, 1_c_size_t, 1_c_size_t, t, 4_c_size_t, b, &
                          4_c_size_t, x=x, ldx=1_c_size_t, result=found, params=params))
    call require(abs(x(1) - 2) < 1e-14_c_double .and. abs(intercept(1) - 1) < 1e-14_c_double &
                 .and. found%rank == 1, 'another line')
    print '(a, f6.3, a, f6.3, a, es8.1)', 'b = ', intercept(1), ' + ', x(1), ' t, error ', errors(1)
  end subroutine squares

  ! The Laplacian of a path of n vertices, by rows.
  subroutine path(n, starts, columns, entries)
    integer(c_size_t), intent(in) :: n
    integer(c_size_t), intent(out) :: starts(n + 1), columns(3 * n - 2)
    real(c_double), intent(out) :: entries(3 * n - 2)
    integer(c_size_t) :: i, j, last
    last = 0
    starts(1) = 0
    do i = 1, n
      do j = max(i - 1, 1_c_size_t), min(i + 1, n)
        last = last + 1
        columns(last) = j - 1
        entries(last) = merge(merge(1, 2, i == 1 .or. i == n), -1, i == j)
      end do
      starts(i + 1) = last
    end do
  end subroutine path

  subroutine factorization()
    integer(c_size_t), parameter :: n = 100
    integer(c_size_t) :: starts(n + 1), columns(3 * n - 2), i, rows, size_of_l
    real(c_double) :: entries(3 * n - 2), x(n)
    type(c_ptr) :: cholesky
    call path(n, starts, columns, entries)
    entries(1) = 2
    call check(cata_cholesky_analyse(n, starts, columns, cholesky=cholesky))
    call check(cata_cholesky_factor(cholesky, starts, columns, entries))
    call check(cata_cholesky_size(cholesky, rows, size_of_l))
    call require(rows == n .and. size_of_l >= 2 * n - 1, 'another size')
    x = 0
    x(n) = 1
    call check(cata_cholesky_solve(cholesky, CATA_COL_MAJOR, 1_c_size_t, x, n))
    call cata_cholesky_free(cholesky)
    ! With the first row held at 0 by one more edge, the values grow by 1 from vertex to vertex.
    call require(maxval(abs(x - [(i, i = 1, n)])) < 1e-10_c_double, 'another solution')
    print '(a, i0, a)', 'a factor of ', size_of_l, ' entries'
  end subroutine factorization

  ! The path of n vertices has the eigenvalues 2 - 2 cos(pi k / n), k = 0 to n - 1.
  subroutine eigenpairs()
    integer(c_size_t), parameter :: n = 100, k = 5
    integer(c_size_t) :: starts(n + 1), columns(3 * n - 2), i
    real(c_double) :: entries(3 * n - 2), values(k), vectors(n, k), worst
    call path(n, starts, columns, entries)
    call check(cata_eigs(n, starts, columns, entries, k=k, eigenvalues=values, &
                         eigenvectors=vectors, ldv=n))
    worst = maxval(abs(values - [(2 - 2 * cos(acos(-1.0_c_double) * (i - 1) / n), i = 1, k)]))
    call require(worst < 1e-10_c_double, 'other eigenvalues')
    print '(a, es8.1)', 'eigenvalues of a path, wrong by ', worst
  end subroutine eigenpairs

  subroutine water()
    integer(c_size_t), parameter :: n = 100, days = 3
    real(c_double) :: full(n), later(n, days)
    type(cata_plant_params) :: params
    type(c_ptr) :: plant
    integer(c_size_t) :: i
    params%struct_size = c_sizeof(params)
    params%loss = 60 / 3.6e6_c_double
    call check(cata_plant_grow(n, 1_c_int64_t, params, plant))
    call check(cata_plant_full_water(plant, n, full))
    call check(cata_plant_water_curve(plant, n, full, days, [(86400.0_c_double * i, i = 1, days)], &
                                      0_c_size_t, result=later))
    call cata_plant_free(plant)
    call require(all(later < spread(full, 2, int(days)) * (1 + 1e-12_c_double)), 'water came')
    print '(a, 3f7.3)', 'water after 1, 2 and 3 days: ', sum(later, 1) / sum(full)
  end subroutine water

end program example
