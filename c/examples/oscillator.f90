! A harmonic oscillator from Fortran. In this folder:
!     gfortran oscillator.f90 -L../../target/release -lleafwise_c -o oscillator
program oscillator
    use, intrinsic :: iso_c_binding
    implicit none
    interface
        integer(c_int) function leafwise_scene_parse(toml, scene) bind(c)
            import :: c_int, c_char, c_int64_t
            character(kind=c_char), intent(in) :: toml(*)
            integer(c_int64_t), intent(out) :: scene
        end function
        integer(c_int) function leafwise_scene_run(scene, initial, n, stride, every, samples, rows, row_stride, column_stride) bind(c)
            import :: c_int, c_int64_t, c_double, c_size_t, c_ptrdiff_t
            integer(c_int64_t), value :: scene, every
            real(c_double), intent(in) :: initial(*)
            integer(c_size_t), value :: n, rows
            integer(c_ptrdiff_t), value :: stride, row_stride, column_stride
            real(c_double), intent(out) :: samples(*)
        end function
        integer(c_int) function leafwise_free(handle) bind(c)
            import :: c_int, c_int64_t
            integer(c_int64_t), value :: handle
        end function
    end interface
    character(*), parameter :: nl = c_new_line
    character(*), parameter :: toml = "[system]" // nl // "variables = ['q', 'p']" // nl // "bracket = 'canonical'" // nl // &
        "hamiltonian = 'p^2/2 + q^2/2'" // nl // "[method]" // nl // "stepper = 'splitting'" // nl // "time-step = 0.1" // nl // &
        "[run]" // nl // "initial = [1, 0]" // nl // "steps = 10" // nl // c_null_char
    integer(c_int64_t) :: scene
    real(c_double) :: samples(2, 11), initial(2) = [1d0, 0d0]
    if (leafwise_scene_parse(toml, scene) /= 0) stop 1
    ! Columns of a Fortran array are rows of the samples.
    if (leafwise_scene_run(scene, initial, 2_c_size_t, 1_c_ptrdiff_t, 1_c_int64_t, samples, 11_c_size_t, 2_c_ptrdiff_t, 1_c_ptrdiff_t) /= 0) stop 2
    print '(2es26.17)', samples(:, 11)
    if (leafwise_free(scene) /= 0) stop 3
end program
