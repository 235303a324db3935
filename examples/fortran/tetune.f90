! SPDX-License-Identifier: Apache-2.0
! Optimizes a mesh from Fortran, over the C interface: tetune/tetune.h, docs/c.md.
module tetune
  use, intrinsic :: iso_c_binding
  implicit none

  integer(c_int), parameter :: vertices = 0, edges = 1, triangles = 2, tetrahedra = 3

  type, bind(c) :: tetune_quality
    real(c_double) :: min_dihedral, max_dihedral, dihedral_p5, mean_ratio, min_mean_ratio, volume
    integer(c_int64_t) :: worst
  end type

  interface
    integer(c_int) function tetune_mesh_create(points, vertex_count, ids, tet_count, mesh) bind(c)
      import
      real(c_double), intent(in) :: points(3, *)
      integer(c_int64_t), value :: vertex_count, tet_count
      integer(c_int32_t), intent(in) :: ids(4, *)
      type(c_ptr), intent(out) :: mesh
    end function
    integer(c_int) function tetune_mesh_read(path, mesh) bind(c)
      import
      character(kind=c_char), intent(in) :: path(*)
      type(c_ptr), intent(out) :: mesh
    end function
    integer(c_int) function tetune_mesh_write(mesh, path) bind(c)
      import
      type(c_ptr), value :: mesh
      character(kind=c_char), intent(in) :: path(*)
    end function
    subroutine tetune_mesh_destroy(mesh) bind(c)
      import
      type(c_ptr), value :: mesh
    end subroutine
    integer(c_int64_t) function tetune_mesh_count(mesh, kind) bind(c)
      import
      type(c_ptr), value :: mesh
      integer(c_int), value :: kind
    end function
    type(c_ptr) function tetune_mesh_points(mesh) bind(c)
      import
      type(c_ptr), value :: mesh
    end function
    type(c_ptr) function tetune_mesh_elements(mesh, kind) bind(c)
      import
      type(c_ptr), value :: mesh
      integer(c_int), value :: kind
    end function
    integer(c_int) function tetune_mesh_get_quality(mesh, quality) bind(c, name="tetune_mesh_quality")
      import
      type(c_ptr), value :: mesh
      type(tetune_quality), intent(out) :: quality
    end function
    integer(c_int) function tetune_options_create(options) bind(c)
      import
      type(c_ptr), intent(out) :: options
    end function
    integer(c_int) function tetune_options_set(options, name, text) bind(c)
      import
      type(c_ptr), value :: options
      character(kind=c_char), intent(in) :: name(*), text(*)
    end function
    subroutine tetune_options_destroy(options) bind(c)
      import
      type(c_ptr), value :: options
    end subroutine
    integer(c_int) function tetune_optimize(mesh, options, progress, user, report) bind(c)
      import
      type(c_ptr), value :: mesh, options, user, report
      type(c_funptr), value :: progress
    end function
    type(c_ptr) function tetune_last_error() bind(c)
      import
    end function
    ! Of the last file that was read or written.
    integer(c_int64_t) function tetune_last_warnings() bind(c)
      import
    end function
    type(c_ptr) function tetune_last_warning(position) bind(c)
      import
      integer(c_int64_t), value :: position
    end function
    integer(c_size_t) function c_strlen(text) bind(c, name="strlen")
      import
      type(c_ptr), value :: text
    end function
  end interface

contains

  ! Stops with the library's sentence if a call has failed.
  subroutine check(status)
    integer(c_int), intent(in) :: status
    if (status == 0) return
    call print_sentence(tetune_last_error())
    error stop 1
  end subroutine

  ! Prints what the last file that was read had beyond the mesh, or what the format of the last one that was written
  ! cannot hold.
  subroutine print_warnings()
    integer(c_int64_t) :: position
    do position = 0, tetune_last_warnings() - 1
      call print_sentence(tetune_last_warning(position))
    end do
  end subroutine

  subroutine print_sentence(sentence)
    type(c_ptr), intent(in) :: sentence
    character(kind=c_char), pointer :: text(:)
    call c_f_pointer(sentence, text, [c_strlen(sentence)])
    print '(*(a))', text
  end subroutine
end module
