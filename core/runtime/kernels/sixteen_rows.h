// The sums of kernels that take 16 rows at a time, of one pose or of so many at once as registers hold: included by their
// files, inside an unnamed namespace and after add_up<poses>() and add_up_quads<poses>() are defined.

template <int at_once>
void column_sums(const std::uint8_t* digits, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  for (std::size_t r = 0; r < rows; r += 16)
    if (panel.poses == 1)
      add_up<1>(digits + r, panel, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < block_poses; pose += at_once)
        add_up<at_once>(digits + r, panel, pose, sums + r);
}

template <int at_once>
void quad_sums(const std::uint8_t* quads, std::size_t rows, const PanelInputs& panel, std::int32_t* sums) {
  for (std::size_t r = 0; r < rows; r += 16)
    if (panel.poses == 1)
      add_up_quads<1>(quads + 4 * r, rows, panel, 0, sums + r);
    else
      for (std::size_t pose = 0; pose < block_poses; pose += at_once)
        add_up_quads<at_once>(quads + 4 * r, rows, panel, pose, sums + r);
}
