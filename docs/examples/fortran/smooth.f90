! smooth: smooth the triangles of a square with displaced nodes by planish, from Fortran.
!
!   gfortran smooth.f90 -o smooth -lplanish && ./smooth
module planish
  use, intrinsic :: iso_c_binding
  implicit none

  type, bind(c) :: planish_mesh ! unused fields are zero
    integer(c_int) :: dim = 0
    integer(c_int64_t) :: n_nodes = 0, n_elements = 0
    type(c_ptr) :: coordinates = c_null_ptr, elements = c_null_ptr
    type(c_ptr) :: constraint = c_null_ptr, direction = c_null_ptr
    integer(c_int64_t) :: n_periodic = 0
    type(c_ptr) :: periodic = c_null_ptr, min_volume = c_null_ptr, elements64 = c_null_ptr
    integer(c_int64_t) :: node_stride = 0, component_stride = 0
    type(c_ptr) :: neighbours = c_null_ptr, neighbours64 = c_null_ptr, part = c_null_ptr
    type(c_ptr) :: cells = c_null_ptr, reference = c_null_ptr, is_layer = c_null_ptr
    type(c_ptr) :: size = c_null_ptr, metric = c_null_ptr, reserved(8) = c_null_ptr
  end type

  type, bind(c) :: planish_error
    integer(c_int) :: code
    integer(c_int64_t) :: element, node
    character(c_char) :: text(512)
  end type

  interface
    integer(c_int) function planish_plan_create(mesh, options, plan, error) bind(c)
      import; type(planish_mesh) :: mesh; type(c_ptr), value :: options
      type(c_ptr) :: plan; type(planish_error) :: error
    end function
    integer(c_int) function planish_smooth(plan, xy, options, result, error) bind(c)
      import; type(c_ptr), value :: plan, options, result
      real(c_double) :: xy(*); type(planish_error) :: error
    end function
    integer(c_int) function planish_measure_elements(plan, xy, ratio, error) bind(c)
      import; type(c_ptr), value :: plan
      real(c_double) :: xy(*), ratio(*); type(planish_error) :: error
    end function
    subroutine planish_plan_destroy(plan) bind(c)
      import; type(c_ptr), value :: plan
    end subroutine
  end interface
end module

program smooth
  use planish
  implicit none
  integer, parameter :: n = 20 ! squares of a side
  real(c_double), target :: xy(2, 0:n, 0:n), ratio(2 * n * n)
  integer(c_int32_t), target :: triangles(6, n, n)
  type(planish_mesh) :: mesh
  type(planish_error) :: error
  type(c_ptr) :: plan = c_null_ptr
  real(c_double) :: angle, off, before
  integer :: i, j, k

  do j = 0, n ! nodes on a grid, inner ones up to 0.4 of a square off it
    do i = 0, n
      angle = 7 * i + 13 * j
      off = merge(0d0, 0.4d0, mod(i, n) == 0 .or. mod(j, n) == 0)
      xy(:, i, j) = [i + off * sin(angle), j + off * cos(2 * angle)]
      if (i == n .or. j == n) cycle
      k = j * (n + 1) + i ! nodes are counted from 0
      triangles(:, i + 1, j + 1) = [k, k + 1, k + n + 2, k, k + n + 2, k + n + 1]
    end do
  end do
  mesh%dim = 2
  mesh%n_nodes = (n + 1)**2
  mesh%n_elements = size(ratio)
  mesh%coordinates = c_loc(xy)
  mesh%elements = c_loc(triangles)
  call check(planish_plan_create(mesh, c_null_ptr, plan, error))
  call check(planish_measure_elements(plan, xy, ratio, error))
  before = maxval(ratio)
  call check(planish_smooth(plan, xy, c_null_ptr, c_null_ptr, error))
  call check(planish_measure_elements(plan, xy, ratio, error))
  call planish_plan_destroy(plan)
  print '(a, f0.4, a, f0.4)', 'worst radius ratio ', before, ' -> ', maxval(ratio)

contains
  subroutine check(status)
    integer(c_int), intent(in) :: status
    integer :: length
    if (status == 0) return
    length = findloc(error%text, c_null_char, 1) - 1
    print '(*(a))', error%text(:length)
    stop 1
  end subroutine
end program
