#pragma once

namespace fb {

// The date of the OpenMP standard that loops run by, such as 201511; 0 in a build without OpenMP.
long openmp_date();

}  // namespace fb
