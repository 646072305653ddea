// Panel sums of kernels that compute 16 rows at a time, for one pose or for as many at once as fit the registers:
// included by kernel files inside an unnamed namespace, after sum_columns<poses>() and sum_quads<poses>() are defined.

template <int poses_at_once>
void column_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  for (std::size_t r = 0; r < rows; r += 16)
    if (panel.poses == 1)
      sum_columns<1>(digits + r, panel, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < poses_per_block; pose += poses_at_once)
        sum_columns<poses_at_once>(digits + r, panel, pose, sums + r);
}

template <int poses_at_once>
void quad_sums(const std::uint8_t* quads, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  for (std::size_t r = 0; r < rows; r += 16)
    if (panel.poses == 1)
      sum_quads<1>(quads + 4 * r, rows, panel, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < poses_per_block; pose += poses_at_once)
        sum_quads<poses_at_once>(quads + 4 * r, rows, panel, pose, sums + r);
}
