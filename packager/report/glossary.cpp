#include "report/glossary.h"

#include <algorithm>
#include <array>

namespace fb::tool {
namespace {

constexpr std::array<GlossaryEntry, 75> entries = {{
    {"mse", "Mean over vertices and frames of the squared distance from the true rig, over D squared."},
    {"rms", "Root of the mse: the same as a length, over D."},
    {"p99", "99 % of all vertices in all frames are nearer to the true rig than this, over D."},
    {"max", "The worst vertex of all frames, over D."},
    {"mfm", "Mean over the frames of the frame's worst vertex, over D: what an eye finds in an ordinary frame."},
    {"p99fm", "99 of 100 frames have no vertex further off than this, over D."},
    {"worst / D", "The worst vertex of all poses counted, over D."},
    {"rms / D", "Root mean square distance from the true rig, over D."},
    {"frames", "Frames that the figures of the row are of."},
    {"clip", "A clip of the source that was measured."},
    {"kind",
     "What a clip was made for. shot: animation; excitation: single controls; regional: expressions of some "
     "groups; calisthenics: walks between extremes; dense: many controls at random."},
    {"split", "test and validation: not trained on; train: trained on."},
    {"mse / ours", "The method's mse over that of the method that the pictures are of: above 1 it is worse."},
    {"dependency mse", "The mse on poses that were trained on."},
    {"dependency max", "The worst vertex on poses that were trained on, over D."},
    {"archive", "Bytes of the archive."},
    {"trained numbers", "Weights and biases of the networks."},
    {"poses", "Poses trained on, or counted in the row."},
    {"seconds", "Time it took."},
    {"normals rms", "Root mean square angle between the vertex normals of the rig and of the method."},
    {"normals p99", "99 % of the vertex normals are off by less than this angle."},
    {"jitter / D", "Root mean square second difference of the error in time, in shots: flicker."},
    {"jump at borders", "Root mean square difference of the error across edges where two regions meet, over D."},
    {"jump inside", "The same inside those regions."},
    {"ratio", "Jump at borders over jump inside: a seam shows as a ratio well above 1."},
    {"border edges", "Edges of the mesh where two regions meet."},
    {"gaps rms / D", "Root mean square error of the gap between places that touch in the rig, over D."},
    {"gaps max / D", "The largest error of such a gap, open or in each other, over D."},
    {"gaps opened",
     "Share of the places that touch in the rig which the method parts by more than 1e-3 D, about a pixel."},
    {"largest leak / D", "Furthest that the archive moves a vertex with a control that leaves it alone in the rig."},
    {"leak / D", "Furthest that the archive moves a vertex with this control, which leaves it alone in the rig."},
    {"controls above the tolerance", "Share of the measured controls that leak more than tolerated."},
    {"moved by", "The controls that move the region most, alone, in the archive; the first most."},
    {"share of error", "The region's part of the squared error of all vertices that belong to a region."},
    {"vertices", "Vertices that belong to the region, or that the control moves alone in the archive."},
    {"vertices moved",
     "Vertices that the control alone moves at least a tenth as far as the one it moves most. Errors in "
     "combination are of these."},
    {"combined: frames", "Measured frames with the control beyond half its reach and another control off rest."},
    {"combined: rms / D", "Root mean square error of the vertices the control moves, in those frames."},
    {"combined: worst / D", "Worst of the vertices the control moves, in those frames."},
    {"alone: poses", "Poses in which all other controls are at rest; in brackets, how many were not trained on."},
    {"alone: worst / D", "Worst vertex in those poses."},
    {"left of training", "Squared coefficient error over squared coefficients in the last epoch, on training poses."},
    {"validation error", "The same on validation poses, which were held back from training."},
    {"share of the energy", "The part of the motion that is left to the networks which lies in the region."},
    {"linear, combined: rms / D", "The same root mean square error of linear blendshapes."},
    {"frames measured", "Frames of all clips that the figures are of."},
    {"mean squared error / D^2",
     "Mean over vertices and frames of the squared distance from the true rig, over D squared."},
    {"root mean square / D", "Root of the mean squared error: the same as a length, over D."},
    {"99 % of vertices are nearer than / D",
     "99 % of all vertices in all frames are nearer to the true rig than this, over D."},
    {"worst vertex of all frames / D", "The largest distance of any vertex in any measured frame, over D."},
    {"worst vertex of 99 in 100 frames / D", "99 of 100 frames have no vertex further off than this, over D."},
    {"worst vertex of a frame, on average / D", "Mean over the frames of the frame's worst vertex, over D."},
    {"normals, degrees rms", "Root mean square angle between the vertex normals of the rig and of the face."},
    {"mse of linear blendshapes over ours", "How many times larger the mean squared error of linear blendshapes is."},
    {"poses trained on", "Poses of the rig that the networks were trained on."},
    {"training, seconds", "Time that training took."},
    {"rig calls besides", "Poses that the rig was asked for besides those trained on, such as to analyse it."},
    {"Independent test", "Errors on poses that nothing was trained on."},
    {"Dependency test", "Errors on poses that were trained on."},
    {"MSE", "Mean over vertices and frames of the squared distance from the true rig, over D squared."},
    {"Max err", "The worst vertex of all frames, over D."},
    {"stage", "A part of the work."},
    {"poses asked to learn", "Different poses that the rig was asked for in order to learn: what a rig budget counts."},
    {"poses evaluated now", "All poses that the rig evaluated in this run."},
    {"section", "A part of the archive's file."},
    {"stored", "Bytes that the section takes in the file."},
    {"unpacked", "Bytes of the section once it is read."},
    {"share of the file", "The section's part of the bytes of the file."},
    {"inputs", "Functions of the controls that the network reads."},
    {"coefficients", "Numbers that the network gives out: columns of the basis."},
    {"numbers", "Weights and biases of the network."},
    {"restarts", "How often training began again because it went wrong."},
    {"control", "A control of the rig."},
    {"region", "A part of the face with a network of its own."},
    {"method", "A way to bake the face."},
}};

}  // namespace

std::span<const GlossaryEntry> glossary() {
  return entries;
}

std::optional<std::size_t> glossary_entry(std::string_view name) {
  const auto entry = std::find_if(entries.begin(), entries.end(), [&](const auto& e) { return e.first == name; });
  if (entry == entries.end()) return std::nullopt;
  return static_cast<std::size_t>(entry - entries.begin());
}

}  // namespace fb::tool
