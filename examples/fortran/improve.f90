! SPDX-License-Identifier: Apache-2.0
! Reads a mesh, hands its arrays to the library as a solver would, optimizes it and writes the result:
!   example_fortran IN OUT
program improve
  use tetune
  implicit none
  character(len=1000) :: input, output
  type(c_ptr) :: file, mesh, options
  type(tetune_quality) :: before, after
  real(c_double), pointer :: points(:, :)
  integer(c_int32_t), pointer :: tets(:, :)
  integer(c_int64_t) :: n, m

  if (command_argument_count() /= 2) error stop "usage: example_fortran IN OUT"
  call get_command_argument(1, input)
  call get_command_argument(2, output)
  call check(tetune_mesh_read(trim(input)//c_null_char, file))
  call print_warnings()
  n = tetune_mesh_count(file, vertices)
  m = tetune_mesh_count(file, tetrahedra)
  call c_f_pointer(tetune_mesh_points(file), points, [3_c_int64_t, n])
  call c_f_pointer(tetune_mesh_elements(file, tetrahedra), tets, [4_c_int64_t, m])

  call check(tetune_mesh_create(points, n, tets, m, mesh))  ! ids count from 0
  call tetune_mesh_destroy(file)
  call check(tetune_options_create(options))
  call check(tetune_options_set(options, "effort"//c_null_char, "best"//c_null_char))
  call check(tetune_mesh_get_quality(mesh, before))
  call check(tetune_optimize(mesh, options, c_null_funptr, c_null_ptr, c_null_ptr))
  call check(tetune_mesh_get_quality(mesh, after))
  print '(a, f0.2, a, f0.2, a)', "smallest dihedral angle: ", before%min_dihedral, " -> ", after%min_dihedral, " degrees"
  call check(tetune_mesh_write(mesh, trim(output)//c_null_char))
  call print_warnings()
  call tetune_options_destroy(options)
  call tetune_mesh_destroy(mesh)
end program
