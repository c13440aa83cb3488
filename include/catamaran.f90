! Catamaran from Fortran 2018: products, least squares, eigenpairs and the water of plants.
!
! Generated from include/catamaran.h by `cargo xtask fortran`: do not edit. MIT OR Apache-2.0.
!
! The functions are those of C: catamaran.h says what they compute and what their arguments are.
! - Arrays that are absent are NULL, and so are structs: without `params` all defaults hold.
! - A struct is 0 at first; its struct_size must be set: params%struct_size = c_sizeof(params).
! - Columns of Fortran's matrices are contiguous: layout is CATA_COL_MAJOR.
! - Vertices, columns and the like are numbered from 0. Strings end with c_null_char.
! - Handles are of type(c_ptr), and functions that are passed of type(c_funptr).
module catamaran
  use, intrinsic :: iso_c_binding
  implicit none
  public

  integer(c_int32_t), parameter :: CATA_OK = 0_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_NULL = 1_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_SHAPE = 2_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_ARGUMENT = 3_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_NON_FINITE = 4_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_NOT_CONVERGED = 5_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_IO = 6_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_OUT_OF_MEMORY = 7_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_BACKEND = 8_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_CANCELLED = 9_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_UNSUPPORTED = 10_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_PANIC = 11_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_RANK = 12_c_int32_t
  integer(c_int32_t), parameter :: CATA_ERR_MESH = 13_c_int32_t
  integer(c_int64_t), parameter :: CATA_CAP_OPENBLAS = 1_c_int64_t
  integer(c_int64_t), parameter :: CATA_CAP_MPI = 2_c_int64_t
  integer(c_int64_t), parameter :: CATA_CAP_OPENCL = 4_c_int64_t
  integer(c_int64_t), parameter :: CATA_CAP_HDF5 = 8_c_int64_t
  integer(c_int64_t), parameter :: CATA_CAP_CHAPTERS = 16_c_int64_t
  integer(c_int32_t), parameter :: CATA_ROW_MAJOR = 101_c_int32_t
  integer(c_int32_t), parameter :: CATA_COL_MAJOR = 102_c_int32_t
  integer(c_int32_t), parameter :: CATA_UPPER = 121_c_int32_t
  integer(c_int32_t), parameter :: CATA_LOWER = 122_c_int32_t
  integer(c_int32_t), parameter :: CATA_BOTH = 123_c_int32_t
  integer(c_int32_t), parameter :: CATA_SCHEME_AUTO = 0_c_int32_t
  integer(c_int32_t), parameter :: CATA_SCHEME_CLASSICAL = 1_c_int32_t
  integer(c_int32_t), parameter :: CATA_SCHEME_ATA2 = 2_c_int32_t
  integer(c_int32_t), parameter :: CATA_SCHEME_WINOGRAD = 3_c_int32_t
  integer(c_int32_t), parameter :: CATA_SCHEME_RXTX = 4_c_int32_t
  integer(c_int32_t), parameter :: CATA_SCHEME_KGP4 = 5_c_int32_t
  integer(c_int32_t), parameter :: CATA_SCHEME_KGP3 = 6_c_int32_t
  integer(c_int32_t), parameter :: CATA_SCHEME_EXACT = 7_c_int32_t
  integer(c_int32_t), parameter :: CATA_SCHEME_FLOAT = 8_c_int32_t
  real(c_double), parameter :: CATA_ERROR_LEAST = -1.0_c_double
  integer(c_int32_t), parameter :: CATA_CENTER_NONE = 0_c_int32_t
  integer(c_int32_t), parameter :: CATA_CENTER_MEAN = 1_c_int32_t
  integer(c_int32_t), parameter :: CATA_CENTER_GIVEN = 2_c_int32_t
  integer(c_int32_t), parameter :: CATA_SUMS_FLOAT = 0_c_int32_t
  integer(c_int32_t), parameter :: CATA_SUMS_EXACT = 1_c_int32_t
  integer(c_int32_t), parameter :: CATA_SUMS_EXTENDED = 2_c_int32_t
  integer(c_int32_t), parameter :: CATA_LAPLACIAN_COTANGENT = 0_c_int32_t
  integer(c_int32_t), parameter :: CATA_LAPLACIAN_INTRINSIC_DELAUNAY = 1_c_int32_t
  integer(c_int32_t), parameter :: CATA_LAPLACIAN_TUFTED = 2_c_int32_t
  integer(c_int32_t), parameter :: CATA_MASS_BARYCENTRIC = 0_c_int32_t
  integer(c_int32_t), parameter :: CATA_MASS_MIXED_VORONOI = 1_c_int32_t
  integer(c_int32_t), parameter :: CATA_MASS_CONSISTENT = 2_c_int32_t
  integer(c_int32_t), parameter :: CATA_BOUNDARY_NEUMANN = 0_c_int32_t
  integer(c_int32_t), parameter :: CATA_BOUNDARY_DIRICHLET = 1_c_int32_t
  integer(c_int32_t), parameter :: CATA_ORTHO_REORTHOGONALIZED = 1_c_int32_t
  integer(c_int32_t), parameter :: CATA_ORTHO_SINGLE_PASS = 2_c_int32_t
  integer(c_int32_t), parameter :: CATA_ORTHO_RANK_REVEALING = 3_c_int32_t
  integer(c_int32_t), parameter :: CATA_NO_PARENT = -1_c_int32_t
  integer(c_int32_t), parameter :: CATA_PLANT_STEM = 0_c_int32_t
  integer(c_int32_t), parameter :: CATA_PLANT_LEAF = 1_c_int32_t
  integer(c_int32_t), parameter :: CATA_PLANT_PINNED = 2_c_int32_t

  type, bind(C) :: cata_accumulator_params
    integer(c_size_t) :: struct_size = 0
    integer(c_size_t) :: threads = 0
    type(c_funptr) :: progress = c_null_funptr
    type(c_ptr) :: progress_user = c_null_ptr
    type(c_ptr) :: lower = c_null_ptr
    type(c_ptr) :: upper = c_null_ptr
    integer(c_int64_t) :: rows = 0
    real(c_double) :: largest_weight = 0
    integer(c_int32_t) :: sums = 0
    integer(c_int32_t) :: centered = 0
  end type cata_accumulator_params

  type, bind(C) :: cata_ata_params
    integer(c_size_t) :: struct_size = 0
    integer(c_size_t) :: threads = 0
    type(c_funptr) :: progress = c_null_funptr
    type(c_ptr) :: progress_user = c_null_ptr
    integer(c_size_t) :: leaf = 0
    integer(c_size_t) :: tasks = 0
    real(c_double) :: error_factor = 0
    type(c_ptr) :: backend = c_null_ptr
    integer(c_int32_t) :: scheme = 0
    integer(c_int32_t) :: reproducible = 0
    integer(c_int32_t) :: pin = 0
  end type cata_ata_params

  type, bind(C) :: cata_cholesky_params
    integer(c_size_t) :: struct_size = 0
    integer(c_size_t) :: threads = 0
    type(c_funptr) :: progress = c_null_funptr
    type(c_ptr) :: progress_user = c_null_ptr
    type(c_ptr) :: order = c_null_ptr
    real(c_double) :: tolerance = 0
    integer(c_int32_t) :: triangle = 0
    integer(c_int32_t) :: semidefinite = 0
  end type cata_cholesky_params

  type, bind(C) :: cata_eigs_params
    integer(c_size_t) :: struct_size = 0
    integer(c_size_t) :: threads = 0
    type(c_funptr) :: progress = c_null_funptr
    type(c_ptr) :: progress_user = c_null_ptr
    integer(c_size_t) :: max_restarts = 0
    integer(c_int64_t) :: seed = 0
    real(c_double) :: tolerance = 0
    real(c_double) :: shift = 0
    integer(c_int32_t) :: has_shift = 0
    integer(c_int32_t) :: verify_count = 0
    integer(c_int32_t) :: laplacian = 0
    integer(c_int32_t) :: mass = 0
    integer(c_int32_t) :: boundary = 0
  end type cata_eigs_params

  type, bind(C) :: cata_gram_params
    integer(c_size_t) :: struct_size = 0
    integer(c_size_t) :: threads = 0
    type(c_funptr) :: progress = c_null_funptr
    type(c_ptr) :: progress_user = c_null_ptr
  end type cata_gram_params

  type, bind(C) :: cata_lstsq_params
    integer(c_size_t) :: struct_size = 0
    integer(c_size_t) :: threads = 0
    type(c_funptr) :: progress = c_null_funptr
    type(c_ptr) :: progress_user = c_null_ptr
    real(c_double) :: ridge = 0
    integer(c_int32_t) :: intercept = 0
    integer(c_int32_t) :: refuse_dependent = 0
    real(c_double) :: confidence = 0
  end type cata_lstsq_params

  type, bind(C) :: cata_lstsq_result
    integer(c_size_t) :: struct_size = 0
    type(c_ptr) :: residual_norms = c_null_ptr
    type(c_ptr) :: r_squared = c_null_ptr
    type(c_ptr) :: intercepts = c_null_ptr
    type(c_ptr) :: standard_errors = c_null_ptr
    type(c_ptr) :: intercept_errors = c_null_ptr
    type(c_ptr) :: dependent = c_null_ptr
    integer(c_size_t) :: rank = 0
    integer(c_size_t) :: degrees_of_freedom = 0
    real(c_double) :: condition = 0
    real(c_double) :: digits = 0
    type(c_ptr) :: t_statistics = c_null_ptr
    type(c_ptr) :: p_values = c_null_ptr
    type(c_ptr) :: lower = c_null_ptr
    type(c_ptr) :: upper = c_null_ptr
    type(c_ptr) :: intercept_p_values = c_null_ptr
    type(c_ptr) :: intercept_lower = c_null_ptr
    type(c_ptr) :: intercept_upper = c_null_ptr
    type(c_ptr) :: residual_deviations = c_null_ptr
    type(c_ptr) :: adjusted_r_squared = c_null_ptr
    type(c_ptr) :: f_statistics = c_null_ptr
    type(c_ptr) :: f_p_values = c_null_ptr
    type(c_ptr) :: covariances = c_null_ptr
    type(c_ptr) :: observations = c_null_ptr
  end type cata_lstsq_result

  type, bind(C) :: cata_ortho_params
    integer(c_size_t) :: struct_size = 0
    integer(c_size_t) :: threads = 0
    type(c_funptr) :: progress = c_null_funptr
    type(c_ptr) :: progress_user = c_null_ptr
    real(c_double) :: threshold = 0
    integer(c_int32_t) :: method = 0
  end type cata_ortho_params

  type, bind(C) :: cata_pca_params
    integer(c_size_t) :: struct_size = 0
    integer(c_size_t) :: threads = 0
    type(c_funptr) :: progress = c_null_funptr
    type(c_ptr) :: progress_user = c_null_ptr
    integer(c_int32_t) :: standardize = 0
  end type cata_pca_params

  type, bind(C) :: cata_plant_params
    integer(c_size_t) :: struct_size = 0
    integer(c_size_t) :: threads = 0
    type(c_funptr) :: progress = c_null_funptr
    type(c_ptr) :: progress_user = c_null_ptr
    real(c_double) :: loss = 0
    real(c_double) :: intake = 0
    real(c_double) :: conductance = 0
    real(c_double) :: modulus = 0
    real(c_double) :: viscosity = 0
    real(c_double) :: density = 0
    real(c_double) :: elasticity_full = 0
    real(c_double) :: elasticity_dry = 0
    real(c_double) :: elasticity_steepness = 0
    real(c_double) :: elasticity_shift = 0
    integer(c_int32_t) :: elasticity_literal = 0
  end type cata_plant_params

  type, bind(C) :: cata_plant_rods_params
    integer(c_size_t) :: struct_size = 0
    integer(c_size_t) :: threads = 0
    type(c_funptr) :: progress = c_null_funptr
    type(c_ptr) :: progress_user = c_null_ptr
    real(c_double) :: gravity(3) = 0
    real(c_double) :: poisson = 0
    real(c_double) :: dry_density = 0
    real(c_double) :: tolerance = 0
    integer(c_size_t) :: iterations = 0
    real(c_double) :: step = 0
    integer(c_size_t) :: step_iterations = 0
    real(c_double) :: damping = 0
  end type cata_plant_rods_params

  interface
    function cata_last_error_message() bind(C) result(returned)
      import
      type(c_ptr) :: returned
    end function cata_last_error_message
    function cata_status_name(status) bind(C) result(returned)
      import
      type(c_ptr) :: returned
      integer(c_int32_t), value :: status
    end function cata_status_name
    function cata_version(major, minor, patch) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), intent(inout), optional :: major, minor, patch
    end function cata_version
    function cata_version_string() bind(C) result(returned)
      import
      type(c_ptr) :: returned
    end function cata_version_string
    function cata_capabilities() bind(C) result(returned)
      import
      integer(c_int64_t) :: returned
    end function cata_capabilities
    function cata_memory_release() bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
    end function cata_memory_release
    function cata_threads_release() bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
    end function cata_threads_release
    function cata_backend_load(path, backend) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(inout) :: backend
    end function cata_backend_load
    function cata_backend_openblas(backend) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), intent(inout) :: backend
    end function cata_backend_openblas
    function cata_backend_name(backend) bind(C) result(returned)
      import
      type(c_ptr) :: returned
      type(c_ptr), value :: backend
    end function cata_backend_name
    subroutine cata_backend_free(backend) bind(C)
      import
      type(c_ptr), value :: backend
    end subroutine cata_backend_free
    function cata_ata_params_init(params, struct_size) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(cata_ata_params), intent(inout), optional :: params
      integer(c_size_t), value :: struct_size
    end function cata_ata_params_init
    function cata_ata_f64(layout, uplo, m, n, alpha, a, lda, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_double), value :: alpha
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), value :: beta
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_f64
    function cata_ata_f32(layout, uplo, m, n, alpha, a, lda, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_float), value :: alpha
      real(c_float), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_float), value :: beta
      real(c_float), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_f32
    function cata_ata_f32_f64(layout, uplo, m, n, alpha, a, lda, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_double), value :: alpha
      real(c_float), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), value :: beta
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_f32_f64
    function cata_ata_scratch_len_f64(m, n, params, len) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: m, n
      type(cata_ata_params), intent(in), optional :: params
      integer(c_size_t), intent(inout), optional :: len
    end function cata_ata_scratch_len_f64
    function cata_ata_scratch_len_f32(m, n, params, len) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: m, n
      type(cata_ata_params), intent(in), optional :: params
      integer(c_size_t), intent(inout), optional :: len
    end function cata_ata_scratch_len_f32
    function cata_ata_with_scratch_f64(layout, uplo, m, n, alpha, a, lda, beta, c, ldc, scratch, &
        scratch_len, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_double), value :: alpha
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), value :: beta
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      real(c_double), intent(inout), optional :: scratch(*)
      integer(c_size_t), value :: scratch_len
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_with_scratch_f64
    function cata_ata_with_scratch_f32(layout, uplo, m, n, alpha, a, lda, beta, c, ldc, scratch, &
        scratch_len, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_float), value :: alpha
      real(c_float), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_float), value :: beta
      real(c_float), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      real(c_float), intent(inout), optional :: scratch(*)
      integer(c_size_t), value :: scratch_len
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_with_scratch_f32
    function cata_aat_f64(layout, uplo, m, n, alpha, a, lda, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_double), value :: alpha
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), value :: beta
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_aat_f64
    function cata_aat_f32(layout, uplo, m, n, alpha, a, lda, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_float), value :: alpha
      real(c_float), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_float), value :: beta
      real(c_float), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_aat_f32
    function cata_ata_batched_f64(layout, uplo, count, m, n, alpha, a, lda, stride_a, beta, c, &
        ldc, stride_c, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: count, m, n
      real(c_double), value :: alpha
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda, stride_a
      real(c_double), value :: beta
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc, stride_c
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_batched_f64
    function cata_ata_batched_f32(layout, uplo, count, m, n, alpha, a, lda, stride_a, beta, c, &
        ldc, stride_c, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: count, m, n
      real(c_float), value :: alpha
      real(c_float), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda, stride_a
      real(c_float), value :: beta
      real(c_float), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc, stride_c
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_batched_f32
    function cata_ata_batched_pointers_f64(layout, uplo, count, m, n, alpha, a, lda, beta, c, &
        ldc, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: count, m, n
      real(c_double), value :: alpha
      type(c_ptr), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), value :: beta
      type(c_ptr), intent(in), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_batched_pointers_f64
    function cata_ata_batched_pointers_f32(layout, uplo, count, m, n, alpha, a, lda, beta, c, &
        ldc, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: count, m, n
      real(c_float), value :: alpha
      type(c_ptr), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_float), value :: beta
      type(c_ptr), intent(in), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_batched_pointers_f32
    function cata_ata_sparse_f64(layout, uplo, m, n, alpha, row_starts, columns, entries, &
        weights, beta, c, ldc, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_double), value :: alpha
      integer(c_size_t), intent(in), optional :: row_starts(*), columns(*)
      real(c_double), intent(in), optional :: entries(*), weights(*)
      real(c_double), value :: beta
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_sparse_f64
    function cata_ata_sparse_f32(layout, uplo, m, n, alpha, row_starts, columns, entries, &
        weights, beta, c, ldc, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_float), value :: alpha
      integer(c_size_t), intent(in), optional :: row_starts(*), columns(*)
      real(c_float), intent(in), optional :: entries(*)
      real(c_double), intent(in), optional :: weights(*)
      real(c_float), value :: beta
      real(c_float), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_sparse_f32
    function cata_ata_plan_f64(m, n, params, size, text) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: m, n
      type(cata_ata_params), intent(in), optional :: params
      integer(c_size_t), value :: size
      character(kind=c_char), intent(inout) :: text(*)
    end function cata_ata_plan_f64
    function cata_ata_plan_f32(m, n, params, size, text) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: m, n
      type(cata_ata_params), intent(in), optional :: params
      integer(c_size_t), value :: size
      character(kind=c_char), intent(inout) :: text(*)
    end function cata_ata_plan_f32
    function cata_atb_f64(layout, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n, k
      real(c_double), value :: alpha
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(in), optional :: b(*)
      integer(c_size_t), value :: ldb
      real(c_double), value :: beta
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_atb_f64
    function cata_atb_f32(layout, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n, k
      real(c_float), value :: alpha
      real(c_float), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_float), intent(in), optional :: b(*)
      integer(c_size_t), value :: ldb
      real(c_float), value :: beta
      real(c_float), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_atb_f32
    function cata_atb_scratch_len_f64(m, n, k, params, len) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: m, n, k
      type(cata_ata_params), intent(in), optional :: params
      integer(c_size_t), intent(inout), optional :: len
    end function cata_atb_scratch_len_f64
    function cata_atb_scratch_len_f32(m, n, k, params, len) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: m, n, k
      type(cata_ata_params), intent(in), optional :: params
      integer(c_size_t), intent(inout), optional :: len
    end function cata_atb_scratch_len_f32
    function cata_atb_with_scratch_f64(layout, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, &
        scratch, scratch_len, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n, k
      real(c_double), value :: alpha
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(in), optional :: b(*)
      integer(c_size_t), value :: ldb
      real(c_double), value :: beta
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      real(c_double), intent(inout), optional :: scratch(*)
      integer(c_size_t), value :: scratch_len
      type(cata_ata_params), intent(in), optional :: params
    end function cata_atb_with_scratch_f64
    function cata_atb_with_scratch_f32(layout, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, &
        scratch, scratch_len, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n, k
      real(c_float), value :: alpha
      real(c_float), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_float), intent(in), optional :: b(*)
      integer(c_size_t), value :: ldb
      real(c_float), value :: beta
      real(c_float), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      real(c_float), intent(inout), optional :: scratch(*)
      integer(c_size_t), value :: scratch_len
      type(cata_ata_params), intent(in), optional :: params
    end function cata_atb_with_scratch_f32
    function cata_aha_c64(layout, uplo, m, n, alpha, a, lda, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_double), value :: alpha
      complex(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), value :: beta
      complex(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_aha_c64
    function cata_aha_c32(layout, uplo, m, n, alpha, a, lda, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_float), value :: alpha
      complex(c_float), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_float), value :: beta
      complex(c_float), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_aha_c32
    function cata_ahb_c64(layout, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n, k
      complex(c_double), intent(in), optional :: alpha, a(*)
      integer(c_size_t), value :: lda
      complex(c_double), intent(in), optional :: b(*)
      integer(c_size_t), value :: ldb
      complex(c_double), intent(in), optional :: beta
      complex(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ahb_c64
    function cata_ahb_c32(layout, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n, k
      complex(c_float), intent(in), optional :: alpha, a(*)
      integer(c_size_t), value :: lda
      complex(c_float), intent(in), optional :: b(*)
      integer(c_size_t), value :: ldb
      complex(c_float), intent(in), optional :: beta
      complex(c_float), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ahb_c32
    function cata_verify_f64(layout, uplo, m, n, alpha, a, lda, c, ldc, rounds, seed, passed, &
        residual, tolerance) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_double), value :: alpha
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(in), optional :: c(*)
      integer(c_size_t), value :: ldc
      integer(c_int32_t), value :: rounds
      integer(c_int64_t), value :: seed
      integer(c_int32_t), intent(inout), optional :: passed
      real(c_double), intent(inout), optional :: residual, tolerance
    end function cata_verify_f64
    function cata_verify_f32(layout, uplo, m, n, alpha, a, lda, c, ldc, rounds, seed, passed, &
        residual, tolerance) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_double), value :: alpha
      real(c_float), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_float), intent(in), optional :: c(*)
      integer(c_size_t), value :: ldc
      integer(c_int32_t), value :: rounds
      integer(c_int64_t), value :: seed
      integer(c_int32_t), intent(inout), optional :: passed
      real(c_double), intent(inout), optional :: residual, tolerance
    end function cata_verify_f32
    function cata_lstsq_params_init(params, struct_size) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(cata_lstsq_params), intent(inout), optional :: params
      integer(c_size_t), value :: struct_size
    end function cata_lstsq_params_init
    function cata_lstsq(layout, m, n, k, a, lda, b, ldb, weights, x, ldx, result, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n, k
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(in), optional :: b(*)
      integer(c_size_t), value :: ldb
      real(c_double), intent(in), optional :: weights(*)
      real(c_double), intent(inout), optional :: x(*)
      integer(c_size_t), value :: ldx
      type(cata_lstsq_result), intent(inout), optional :: result
      type(cata_lstsq_params), intent(in), optional :: params
    end function cata_lstsq
    function cata_pca_params_init(params, struct_size) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(cata_pca_params), intent(inout), optional :: params
      integer(c_size_t), value :: struct_size
    end function cata_pca_params_init
    function cata_pca(layout, m, n, a, lda, count, components, ldcomponents, explained_variance, &
        explained_variance_ratio, singular_values, mean, scale, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda, count
      real(c_double), intent(inout), optional :: components(*)
      integer(c_size_t), value :: ldcomponents
      real(c_double), intent(inout), optional :: explained_variance(*), explained_variance_ratio(*)
      real(c_double), intent(inout), optional :: singular_values(*), mean(*), scale(*)
      type(cata_pca_params), intent(in), optional :: params
    end function cata_pca
    function cata_gram_params_init(params, struct_size) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(cata_gram_params), intent(inout), optional :: params
      integer(c_size_t), value :: struct_size
    end function cata_gram_params_init
    function cata_svd(layout, m, n, a, lda, values, v, ldv, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(inout), optional :: values(*), v(*)
      integer(c_size_t), value :: ldv
      type(cata_gram_params), intent(in), optional :: params
    end function cata_svd
    function cata_gram_extended(layout, m, n, a, lda, weights, centering, high, ldhigh, low, &
        ldlow, exact, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(in), optional :: weights(*)
      integer(c_int32_t), value :: centering
      real(c_double), intent(inout), optional :: high(*)
      integer(c_size_t), value :: ldhigh
      real(c_double), intent(inout), optional :: low(*)
      integer(c_size_t), value :: ldlow
      integer(c_int32_t), intent(inout), optional :: exact
      type(cata_gram_params), intent(in), optional :: params
    end function cata_gram_extended
    function cata_gram_correlation(layout, m, n, a, lda, c, ldc, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_gram_params), intent(in), optional :: params
    end function cata_gram_correlation
    function cata_gram_orthogonality(layout, m, n, q, ldq, max, frobenius, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n
      real(c_double), intent(in), optional :: q(*)
      integer(c_size_t), value :: ldq
      real(c_double), intent(inout), optional :: max, frobenius
      type(cata_gram_params), intent(in), optional :: params
    end function cata_gram_orthogonality
    function cata_gram_cholesky_qr(layout, m, n, a, lda, r, ldr, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m, n
      real(c_double), intent(inout), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(inout), optional :: r(*)
      integer(c_size_t), value :: ldr
      type(cata_gram_params), intent(in), optional :: params
    end function cata_gram_cholesky_qr
    function cata_ata_rows_f64(layout, uplo, m, n, alpha, a, lda, weights, centering, center, &
        beta, c, ldc, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_double), value :: alpha
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(in), optional :: weights(*)
      integer(c_int32_t), value :: centering
      real(c_double), intent(in), optional :: center(*)
      real(c_double), value :: beta
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_rows_f64
    function cata_ata_rows_f32(layout, uplo, m, n, alpha, a, lda, weights, centering, center, &
        beta, c, ldc, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout, uplo
      integer(c_size_t), value :: m, n
      real(c_float), value :: alpha
      real(c_float), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_float), intent(in), optional :: weights(*)
      integer(c_int32_t), value :: centering
      real(c_float), intent(in), optional :: center(*)
      real(c_float), value :: beta
      real(c_float), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
      type(cata_ata_params), intent(in), optional :: params
    end function cata_ata_rows_f32
    function cata_accumulator_params_init(params, struct_size) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(cata_accumulator_params), intent(inout), optional :: params
      integer(c_size_t), value :: struct_size
    end function cata_accumulator_params_init
    function cata_accumulator_new(n, params, accumulator) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n
      type(cata_accumulator_params), intent(in), optional :: params
      type(c_ptr), intent(inout) :: accumulator
    end function cata_accumulator_new
    function cata_accumulator_read(path, params, accumulator) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      character(kind=c_char), intent(in) :: path(*)
      type(cata_accumulator_params), intent(in), optional :: params
      type(c_ptr), intent(inout) :: accumulator
    end function cata_accumulator_read
    function cata_accumulator_write(accumulator, path) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: accumulator
      character(kind=c_char), intent(in) :: path(*)
    end function cata_accumulator_write
    subroutine cata_accumulator_free(accumulator) bind(C)
      import
      type(c_ptr), value :: accumulator
    end subroutine cata_accumulator_free
    function cata_accumulator_add(accumulator, layout, m, a, lda, &
        weights) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: accumulator
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(in), optional :: weights(*)
    end function cata_accumulator_add
    function cata_accumulator_remove(accumulator, layout, m, a, lda, &
        weights) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: accumulator
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: m
      real(c_double), intent(in), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(in), optional :: weights(*)
    end function cata_accumulator_remove
    function cata_accumulator_add_file(accumulator, path) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: accumulator
      character(kind=c_char), intent(in) :: path(*)
    end function cata_accumulator_add_file
    function cata_accumulator_merge(accumulator, other) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: accumulator, other
    end function cata_accumulator_merge
    function cata_accumulator_rows(accumulator, rows, weight, mean) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: accumulator
      integer(c_int64_t), intent(inout), optional :: rows
      real(c_double), intent(inout), optional :: weight, mean(*)
    end function cata_accumulator_rows
    function cata_accumulator_gram(accumulator, layout, uplo, alpha, c, &
        ldc) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: accumulator
      integer(c_int32_t), value :: layout, uplo
      real(c_double), value :: alpha
      real(c_double), intent(inout), optional :: c(*)
      integer(c_size_t), value :: ldc
    end function cata_accumulator_gram
    function cata_accumulator_lstsq(accumulator, k, layout, x, ldx, result, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: accumulator
      integer(c_size_t), value :: k
      integer(c_int32_t), value :: layout
      real(c_double), intent(inout), optional :: x(*)
      integer(c_size_t), value :: ldx
      type(cata_lstsq_result), intent(inout), optional :: result
      type(cata_lstsq_params), intent(in), optional :: params
    end function cata_accumulator_lstsq
    function cata_accumulator_pca(accumulator, layout, count, components, ldcomponents, &
        explained_variance, explained_variance_ratio, singular_values, mean, scale, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: accumulator
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: count
      real(c_double), intent(inout), optional :: components(*)
      integer(c_size_t), value :: ldcomponents
      real(c_double), intent(inout), optional :: explained_variance(*), explained_variance_ratio(*)
      real(c_double), intent(inout), optional :: singular_values(*), mean(*), scale(*)
      type(cata_pca_params), intent(in), optional :: params
    end function cata_accumulator_pca
    function cata_cholesky_params_init(params, struct_size) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(cata_cholesky_params), intent(inout), optional :: params
      integer(c_size_t), value :: struct_size
    end function cata_cholesky_params_init
    function cata_cholesky_analyse(n, row_starts, columns, params, &
        cholesky) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n
      integer(c_size_t), intent(in), optional :: row_starts(*), columns(*)
      type(cata_cholesky_params), intent(in), optional :: params
      type(c_ptr), intent(inout) :: cholesky
    end function cata_cholesky_analyse
    subroutine cata_cholesky_free(cholesky) bind(C)
      import
      type(c_ptr), value :: cholesky
    end subroutine cata_cholesky_free
    function cata_cholesky_factor(cholesky, row_starts, columns, entries) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: cholesky
      integer(c_size_t), intent(in), optional :: row_starts(*), columns(*)
      real(c_double), intent(in), optional :: entries(*)
    end function cata_cholesky_factor
    function cata_cholesky_solve(cholesky, layout, count, x, ldx) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: cholesky
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: count
      real(c_double), intent(inout), optional :: x(*)
      integer(c_size_t), value :: ldx
    end function cata_cholesky_solve
    function cata_cholesky_solve_rows(cholesky, layout, count, b, ldb, n_rows, rows, x, &
        ldx) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: cholesky
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: count
      real(c_double), intent(in), optional :: b(*)
      integer(c_size_t), value :: ldb, n_rows
      integer(c_size_t), intent(in), optional :: rows(*)
      real(c_double), intent(inout), optional :: x(*)
      integer(c_size_t), value :: ldx
    end function cata_cholesky_solve_rows
    function cata_cholesky_size(cholesky, n, entries, held) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: cholesky
      integer(c_size_t), intent(inout), optional :: n, entries, held
    end function cata_cholesky_size
    function cata_cholesky_held(cholesky, held) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: cholesky
      integer(c_size_t), intent(inout), optional :: held(*)
    end function cata_cholesky_held
    function cata_cholesky_weakest(cholesky, row, ratio) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: cholesky
      integer(c_size_t), intent(inout), optional :: row
      real(c_double), intent(inout), optional :: ratio
    end function cata_cholesky_weakest
    function cata_eigs_params_init(params, struct_size) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(cata_eigs_params), intent(inout), optional :: params
      integer(c_size_t), value :: struct_size
    end function cata_eigs_params_init
    function cata_eigs(n, row_starts, columns, entries, masses, k, eigenvalues, eigenvectors, &
        ldv, residuals, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n
      integer(c_size_t), intent(in), optional :: row_starts(*), columns(*)
      real(c_double), intent(in), optional :: entries(*), masses(*)
      integer(c_size_t), value :: k
      real(c_double), intent(inout), optional :: eigenvalues(*), eigenvectors(*)
      integer(c_size_t), value :: ldv
      real(c_double), intent(inout), optional :: residuals(*)
      type(cata_eigs_params), intent(in), optional :: params
    end function cata_eigs
    function cata_eigs_sliced(n, row_starts, columns, entries, masses, k, memory, slice, user, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n
      integer(c_size_t), intent(in), optional :: row_starts(*), columns(*)
      real(c_double), intent(in), optional :: entries(*), masses(*)
      integer(c_size_t), value :: k, memory
      type(c_funptr), value :: slice
      type(c_ptr), value :: user
      type(cata_eigs_params), intent(in), optional :: params
    end function cata_eigs_sliced
    function cata_eigs_two_level(n, row_starts, columns, entries, masses, coarse, p_row_starts, &
        p_columns, p_entries, k, eigenvalues, eigenvectors, ldv, residuals, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n
      integer(c_size_t), intent(in), optional :: row_starts(*), columns(*)
      real(c_double), intent(in), optional :: entries(*), masses(*)
      integer(c_size_t), value :: coarse
      integer(c_size_t), intent(in), optional :: p_row_starts(*), p_columns(*)
      real(c_double), intent(in), optional :: p_entries(*)
      integer(c_size_t), value :: k
      real(c_double), intent(inout), optional :: eigenvalues(*), eigenvectors(*)
      integer(c_size_t), value :: ldv
      real(c_double), intent(inout), optional :: residuals(*)
      type(cata_eigs_params), intent(in), optional :: params
    end function cata_eigs_two_level
    function cata_eigs_count(n, row_starts, columns, entries, masses, value, count, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n
      integer(c_size_t), intent(in), optional :: row_starts(*), columns(*)
      real(c_double), intent(in), optional :: entries(*), masses(*)
      real(c_double), value :: value
      integer(c_size_t), intent(inout), optional :: count
      type(cata_eigs_params), intent(in), optional :: params
    end function cata_eigs_count
    function cata_ortho_params_init(params, struct_size) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(cata_ortho_params), intent(inout), optional :: params
      integer(c_size_t), value :: struct_size
    end function cata_ortho_params_init
    function cata_ortho_gram_schmidt(layout, n, c, a, lda, masses, r, ldr, kept, rank, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: n, c
      real(c_double), intent(inout), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(in), optional :: masses(*)
      real(c_double), intent(inout), optional :: r(*)
      integer(c_size_t), value :: ldr
      integer(c_size_t), intent(inout), optional :: kept(*), rank
      type(cata_ortho_params), intent(in), optional :: params
    end function cata_ortho_gram_schmidt
    function cata_ortho_cholesky_qr(layout, n, c, a, lda, masses, r, ldr, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_int32_t), value :: layout
      integer(c_size_t), value :: n, c
      real(c_double), intent(inout), optional :: a(*)
      integer(c_size_t), value :: lda
      real(c_double), intent(in), optional :: masses(*)
      real(c_double), intent(inout), optional :: r(*)
      integer(c_size_t), value :: ldr
      type(cata_ortho_params), intent(in), optional :: params
    end function cata_ortho_cholesky_qr
    function cata_mesh_free_components(n_vertices, vertices, n_faces, faces, count, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n_vertices
      real(c_double), intent(in), optional :: vertices(*)
      integer(c_size_t), value :: n_faces
      integer(c_int32_t), intent(in), optional :: faces(*)
      integer(c_size_t), intent(inout), optional :: count
      type(cata_eigs_params), intent(in), optional :: params
    end function cata_mesh_free_components
    function cata_mesh_eigs(n_vertices, vertices, n_faces, faces, k, eigenvalues, eigenvectors, &
        ldv, residuals, masses, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n_vertices
      real(c_double), intent(in), optional :: vertices(*)
      integer(c_size_t), value :: n_faces
      integer(c_int32_t), intent(in), optional :: faces(*)
      integer(c_size_t), value :: k
      real(c_double), intent(inout), optional :: eigenvalues(*), eigenvectors(*)
      integer(c_size_t), value :: ldv
      real(c_double), intent(inout), optional :: residuals(*), masses(*)
      type(cata_eigs_params), intent(in), optional :: params
    end function cata_mesh_eigs
    function cata_mesh_eigs_sliced(n_vertices, vertices, n_faces, faces, k, memory, slice, user, &
        params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n_vertices
      real(c_double), intent(in), optional :: vertices(*)
      integer(c_size_t), value :: n_faces
      integer(c_int32_t), intent(in), optional :: faces(*)
      integer(c_size_t), value :: k, memory
      type(c_funptr), value :: slice
      type(c_ptr), value :: user
      type(cata_eigs_params), intent(in), optional :: params
    end function cata_mesh_eigs_sliced
    function cata_mesh_part_eigenvalues(n_vertices, vertices, n_faces, faces, mask, k, &
        eigenvalues, params) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n_vertices
      real(c_double), intent(in), optional :: vertices(*)
      integer(c_size_t), value :: n_faces
      integer(c_int32_t), intent(in), optional :: faces(*)
      integer(c_int8_t), intent(in), optional :: mask(*)
      integer(c_size_t), value :: k
      real(c_double), intent(inout), optional :: eigenvalues(*)
      type(cata_eigs_params), intent(in), optional :: params
    end function cata_mesh_part_eigenvalues
    function cata_plant_params_init(params, struct_size) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(cata_plant_params), intent(inout), optional :: params
      integer(c_size_t), value :: struct_size
    end function cata_plant_params_init
    function cata_plant_new(n, tails, radii, parents, kinds, base, params, &
        plant) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n
      real(c_double), intent(in), optional :: tails(*), radii(*)
      integer(c_int32_t), intent(in), optional :: parents(*), kinds(*)
      real(c_double), intent(in), optional :: base(*)
      type(cata_plant_params), intent(in), optional :: params
      type(c_ptr), intent(inout) :: plant
    end function cata_plant_new
    function cata_plant_read(path, params, plant) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      character(kind=c_char), intent(in) :: path(*)
      type(cata_plant_params), intent(in), optional :: params
      type(c_ptr), intent(inout) :: plant
    end function cata_plant_read
    function cata_plant_read_with(path, unit, individual, params, plant) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      character(kind=c_char), intent(in) :: path(*)
      real(c_double), intent(in), optional :: unit(*)
      character(kind=c_char), intent(in) :: individual(*)
      type(cata_plant_params), intent(in), optional :: params
      type(c_ptr), intent(inout) :: plant
    end function cata_plant_read_with
    function cata_plant_grow(n, seed, params, plant) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      integer(c_size_t), value :: n
      integer(c_int64_t), value :: seed
      type(cata_plant_params), intent(in), optional :: params
      type(c_ptr), intent(inout) :: plant
    end function cata_plant_grow
    subroutine cata_plant_free(plant) bind(C)
      import
      type(c_ptr), value :: plant
    end subroutine cata_plant_free
    function cata_plant_size(plant) bind(C) result(returned)
      import
      integer(c_size_t) :: returned
      type(c_ptr), value :: plant
    end function cata_plant_size
    function cata_plant_segments(plant, n, tails, radii, parents, kinds, &
        base) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      integer(c_size_t), value :: n
      real(c_double), intent(inout), optional :: tails(*), radii(*)
      integer(c_int32_t), intent(inout), optional :: parents(*), kinds(*)
      real(c_double), intent(inout), optional :: base(*)
    end function cata_plant_segments
    function cata_plant_full_water(plant, n, water) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      integer(c_size_t), value :: n
      real(c_double), intent(inout), optional :: water(*)
    end function cata_plant_full_water
    function cata_plant_set_loss(plant, loss) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      real(c_double), value :: loss
    end function cata_plant_set_loss
    function cata_plant_set_intake(plant, intake) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      real(c_double), value :: intake
    end function cata_plant_set_intake
    function cata_plant_weaken(plant, node, factor) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      integer(c_size_t), value :: node
      real(c_double), value :: factor
    end function cata_plant_weaken
    function cata_plant_rates(plant, n, rates) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      integer(c_size_t), value :: n
      real(c_double), intent(inout), optional :: rates(*)
    end function cata_plant_rates
    function cata_plant_water_after(plant, n, water, seconds, result) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      integer(c_size_t), value :: n
      real(c_double), intent(in), optional :: water(*)
      real(c_double), value :: seconds
      real(c_double), intent(inout), optional :: result(*)
    end function cata_plant_water_after
    function cata_plant_water_curve(plant, n, water, n_times, times, n_intervals, intervals, &
        result) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      integer(c_size_t), value :: n
      real(c_double), intent(in), optional :: water(*)
      integer(c_size_t), value :: n_times
      real(c_double), intent(in), optional :: times(*)
      integer(c_size_t), value :: n_intervals
      real(c_double), intent(in), optional :: intervals(*)
      real(c_double), intent(inout), optional :: result(*)
    end function cata_plant_water_curve
    function cata_plant_start(plant, n, water, step) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      integer(c_size_t), value :: n
      real(c_double), intent(in), optional :: water(*)
      real(c_double), value :: step
    end function cata_plant_start
    function cata_plant_step(plant, count, n, water) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      integer(c_size_t), value :: count, n
      real(c_double), intent(inout), optional :: water(*)
    end function cata_plant_step
    function cata_plant_stiffness(plant, n, water, moduli) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      integer(c_size_t), value :: n
      real(c_double), intent(in), optional :: water(*)
      real(c_double), intent(inout), optional :: moduli(*)
    end function cata_plant_stiffness
    function cata_plant_rods_params_init(params, struct_size) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(cata_plant_rods_params), intent(inout), optional :: params
      integer(c_size_t), value :: struct_size
    end function cata_plant_rods_params_init
    function cata_plant_rods_new(plant, params, rods) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant
      type(cata_plant_rods_params), intent(in), optional :: params
      type(c_ptr), intent(inout) :: rods
    end function cata_plant_rods_new
    subroutine cata_plant_rods_free(rods) bind(C)
      import
      type(c_ptr), value :: rods
    end subroutine cata_plant_rods_free
    function cata_plant_rods_set_state(rods, n, moduli, water) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: rods
      integer(c_size_t), value :: n
      real(c_double), intent(in), optional :: moduli(*), water(*)
    end function cata_plant_rods_set_state
    function cata_plant_rods_set_pose(rods, n, rotations) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: rods
      integer(c_size_t), value :: n
      real(c_double), intent(in), optional :: rotations(*)
    end function cata_plant_rods_set_pose
    function cata_plant_rods_pose(rods, n, heads, tails, rotations) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: rods
      integer(c_size_t), value :: n
      real(c_double), intent(inout), optional :: heads(*), tails(*), rotations(*)
    end function cata_plant_rods_pose
    function cata_plant_rods_relax(rods, iterations, residual) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: rods
      integer(c_size_t), intent(inout), optional :: iterations
      real(c_double), intent(inout), optional :: residual
    end function cata_plant_rods_relax
    function cata_plant_rods_step(rods, count, gap) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: rods
      integer(c_size_t), value :: count
      real(c_double), intent(inout), optional :: gap
    end function cata_plant_rods_step
    function cata_plant_rods_tubes(rods, n, sides, thinnest, vertices, &
        faces) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: rods
      integer(c_size_t), value :: n, sides
      real(c_double), value :: thinnest
      real(c_double), intent(inout), optional :: vertices(*)
      integer(c_int32_t), intent(inout), optional :: faces(*)
    end function cata_plant_rods_tubes
    function cata_plant_wilt(plant, rods, n_times, times, n_intervals, intervals, n, water, &
        moduli, tails, rotations) bind(C) result(returned)
      import
      integer(c_int32_t) :: returned
      type(c_ptr), value :: plant, rods
      integer(c_size_t), value :: n_times
      real(c_double), intent(in), optional :: times(*)
      integer(c_size_t), value :: n_intervals
      real(c_double), intent(in), optional :: intervals(*)
      integer(c_size_t), value :: n
      real(c_double), intent(inout), optional :: water(*), moduli(*), tails(*), rotations(*)
    end function cata_plant_wilt
end interface

contains

  !> Returns the message of the last call of this thread that failed.
  function cata_message() result(text)
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    type(c_ptr) :: first
    integer(c_size_t) :: i, length
    interface
      function c_strlen(string) bind(C, name='strlen') result(returned)
        import
        type(c_ptr), value :: string
        integer(c_size_t) :: returned
      end function c_strlen
    end interface
    first = cata_last_error_message()
    length = c_strlen(first)
    call c_f_pointer(first, letters, [length])
    allocate (character(len=length) :: text)
    do i = 1, length
      text(i:i) = letters(i)
    end do
  end function cata_message

end module catamaran
