// Panel sums of kernels that compute 32 rows of one pose at a time, so that indices and inputs are read half as often,
// or 16 rows of two poses: included by kernel files inside an unnamed namespace, after sum_columns<blocks of 16 rows,
// poses>() and sum_quads<vectors of four rows, poses>() are defined.

void column_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  std::size_t r = 0;
  if (panel.poses == 1)
    for (; r + 32 <= rows; r += 32) sum_columns<2, 1>(digits + r, panel, 0, sums + r);
  for (; r < rows; r += 16)
    if (panel.poses == 1)
      sum_columns<1, 1>(digits + r, panel, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < poses_per_block; pose += 2)
        sum_columns<1, 2>(digits + r, panel, pose, sums + r);
}

void quad_sums(const std::uint8_t* quads, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  std::size_t r = 0;
  if (panel.poses == 1)
    for (; r + 32 <= rows; r += 32) sum_quads<8, 1>(quads + 4 * r, rows, panel, 0, sums + r);
  for (; r < rows; r += 16)
    if (panel.poses == 1)
      sum_quads<4, 1>(quads + 4 * r, rows, panel, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < poses_per_block; pose += 2)
        sum_quads<4, 2>(quads + 4 * r, rows, panel, pose, sums + r);
}
