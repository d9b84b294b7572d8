// Plots as SVG text: a page with a title, panels in rows and one legend for all of them.
//
// Only what the pages of this room need. gnuplot and matplotlib are the roads not taken: a page
// should come out of the program itself on any machine, and be the same text for the same numbers.
#pragma once

#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace maille::plot {

enum class Marker { none, circle, square, triangle, diamond, cross, plus, tick };
enum class Line { none, solid, dashed, dotted };

struct Style {
  const char* color = "#444";  // as SVG takes it; a literal
  Marker marker = Marker::none;
  Line line = Line::none;
  bool hollow = false;  // the marker's outline alone
};

enum class Scale {
  linear,
  log,
  log_with_zero,  // with a place of its own for 0 (and below), beneath the lowest decade
  names           // 0, 1, 2 … from the top (y) or the left (x), labelled by Axis::names
};

struct Axis {
  std::string title;  // with its unit
  Scale scale = Scale::linear;
  double low = 0.0;  // low < high; above 0 on log scales, and widened there to whole decades;
                     // of no account for names
  double high = 1.0;
  std::vector<std::string> names;
};

struct Series {
  Style style;
  std::vector<glm::dvec2> points;  // drawn in this order
  // Instead of none: from where to where each point was seen along x, a whisker.
  std::vector<glm::dvec2> x_ranges;
  std::string label;  // beside the last point that is drawn, right of it where there is room
};

struct Panel {
  std::string title;
  Axis x;
  Axis y;
  std::vector<Series> series;  // later ones on top
};

struct LegendEntry {
  std::string text;  // empty: a place left free
  Style style;
};

struct Page {
  std::string title;
  std::vector<std::string> notes;  // lines under the title
  std::vector<Panel> panels;
  std::vector<LegendEntry> legend;  // down the columns
  int legend_columns = 4;
  int panels_in_row = 0;  // 0: all
};

// UTF-8, well-formed whatever the texts hold. Points outside an axis are left out.
std::string to_svg(const Page& page);

// Whole decades around the values that are above 0; 1 to 10 where none is.
struct Decades {
  double low;
  double high;
};
Decades decades_around(const std::vector<double>& values);

// Colours that the colour-blind tell apart (Okabe and Ito 2008).
namespace color {
inline constexpr const char* kBlue = "#0072b2";
inline constexpr const char* kOrange = "#d55e00";
inline constexpr const char* kGreen = "#009e73";
inline constexpr const char* kPurple = "#aa4499";
inline constexpr const char* kSky = "#56b4e9";
inline constexpr const char* kYellow = "#c99700";
inline constexpr const char* kGrey = "#777777";
}  // namespace color

}  // namespace maille::plot
