#include "measure/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace maille::plot {
namespace {

constexpr double kMargin = 24;
constexpr double kPanelWidth = 400;   // of the drawing area
constexpr double kPanelHeight = 340;  // of the drawing area
constexpr double kAxisRoom = 62;      // left of a panel, for labels and the axis title
constexpr double kNameLetter = 6.3;   // width of a letter of a name, for longer labels
constexpr double kBelow = 52;         // below a panel, for the same
constexpr double kAbove = 22;         // above a panel that is below another, for its title
constexpr double kLineHeight = 18;
constexpr double kZeroBand = 34;  // height of the place for 0

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", value);
  std::string out = text;
  out.erase(out.find_last_not_of('0') + 1);
  if (out.ends_with('.')) out.pop_back();
  return out == "-0" ? "0" : out;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default: out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return out;
}

std::string line_between(glm::dvec2 a, glm::dvec2 b, const std::string& attributes) {
  return "<line x1=\"" + number(a.x) + "\" y1=\"" + number(a.y) + "\" x2=\"" + number(b.x) +
         "\" y2=\"" + number(b.y) + "\" " + attributes + "/>\n";
}

std::string text_at(glm::dvec2 at, const std::string& text, const std::string& attributes) {
  return "<text x=\"" + number(at.x) + "\" y=\"" + number(at.y) + "\" " + attributes + ">" +
         escaped(text) + "</text>\n";
}

std::string dashes(Line line) {
  if (line == Line::dashed) return " stroke-dasharray=\"7 4\"";
  if (line == Line::dotted) return " stroke-dasharray=\"2 4\"";
  return "";
}

std::string polygon(glm::dvec2 at, std::initializer_list<glm::dvec2> corners,
                    const std::string& attributes) {
  std::string points;
  for (const glm::dvec2 corner : corners) {
    points += number(at.x + corner.x) + "," + number(at.y + corner.y) + " ";
  }
  points.pop_back();
  return "<polygon points=\"" + points + "\" " + attributes + "/>\n";
}

std::string marker_at(glm::dvec2 at, const Style& style) {
  const std::string color = style.color;
  const std::string paint = "fill=\"" + (style.hollow ? "white" : color) + "\" stroke=\"" + color +
                            "\" stroke-width=\"1.6\"";
  const auto stroke = "stroke=\"" + color + "\" stroke-width=\"2.4\"";
  switch (style.marker) {
    case Marker::none: return "";
    case Marker::circle:
      return "<circle cx=\"" + number(at.x) + "\" cy=\"" + number(at.y) + "\" r=\"4.6\" " + paint +
             "/>\n";
    case Marker::square:
      return polygon(at, {{-4.3, -4.3}, {4.3, -4.3}, {4.3, 4.3}, {-4.3, 4.3}}, paint);
    case Marker::triangle: return polygon(at, {{0, -5.6}, {5.2, 4}, {-5.2, 4}}, paint);
    case Marker::diamond: return polygon(at, {{0, -6}, {6, 0}, {0, 6}, {-6, 0}}, paint);
    case Marker::cross:
      return line_between(at - 4.2, at + 4.2, stroke) +
             line_between(at + glm::dvec2(-4.2, 4.2), at + glm::dvec2(4.2, -4.2), stroke);
    case Marker::tick: return line_between(at - glm::dvec2(0, 8), at + glm::dvec2(0, 8), stroke);
    case Marker::plus:
      return line_between(at - glm::dvec2(5.4, 0), at + glm::dvec2(5.4, 0), stroke) +
             line_between(at - glm::dvec2(0, 5.4), at + glm::dvec2(0, 5.4), stroke);
  }
  return "";
}

std::string power_of_ten(int exponent) {
  static const char* const kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent))) text += kDigits[digit - '0'];
  return text;
}

struct Tick {
  double value;
  std::string label;  // empty: a faint line only
};

// Values along one axis to lengths from its beginning (left or bottom).
class Ruler {
 public:
  Ruler(const Axis& axis, double length, bool from_the_top) : axis_(axis), length_(length) {
    if (axis.scale == Scale::names) {
      const auto count = static_cast<double>(axis.names.size());
      low_ = from_the_top ? count - 0.5 : -0.5;
      high_ = from_the_top ? -0.5 : count - 0.5;
    } else if (logarithmic()) {
      low_ = std::floor(std::log10(axis.low) + 1e-9);
      high_ = std::max(low_ + 1.0, std::ceil(std::log10(axis.high) - 1e-9));
    } else {
      low_ = axis.low;
      high_ = axis.high;
    }
    begin_ = axis.scale == Scale::log_with_zero ? kZeroBand : 0.0;
  }

  double begin() const { return begin_; }

  std::optional<double> at(double value) const {
    if (!std::isfinite(value)) return std::nullopt;
    if (logarithmic() && value <= 0.0) {
      if (axis_.scale == Scale::log_with_zero) return kZeroBand / 2.0;
      return std::nullopt;
    }
    const double share = ((logarithmic() ? std::log10(value) : value) - low_) / (high_ - low_);
    if (share < -1e-6 || share > 1.0 + 1e-6) return std::nullopt;
    return begin_ + share * (length_ - begin_);
  }

  std::vector<Tick> ticks() const {
    if (axis_.scale == Scale::names) return name_ticks();
    return logarithmic() ? decade_ticks() : round_ticks();
  }

 private:
  bool logarithmic() const {
    return axis_.scale == Scale::log || axis_.scale == Scale::log_with_zero;
  }

  std::vector<Tick> name_ticks() const {
    std::vector<Tick> ticks;
    for (const std::string& name : axis_.names) {
      ticks.push_back({static_cast<double>(ticks.size()), name});
    }
    return ticks;
  }

  std::vector<Tick> decade_ticks() const {
    std::vector<Tick> ticks;
    if (axis_.scale == Scale::log_with_zero) ticks.push_back({0.0, "0"});
    // One way to write them along an axis.
    const bool plain = low_ >= -2.0 && high_ <= 4.0;
    for (int decade = static_cast<int>(low_); decade <= static_cast<int>(high_); ++decade) {
      const double value = std::pow(10.0, decade);
      ticks.push_back({value, plain ? number(value) : power_of_ten(decade)});
      for (int n = 2; n < 10 && decade < static_cast<int>(high_); ++n)
        ticks.push_back({n * value, ""});
    }
    return ticks;
  }

  std::vector<Tick> round_ticks() const {
    const double rough = (high_ - low_) / 6.0;
    const double decade = std::pow(10.0, std::floor(std::log10(rough)));
    double step = 10.0 * decade;
    for (const double nice : {5.0, 2.0, 1.0}) {
      if (nice * decade >= rough) step = nice * decade;
    }
    std::vector<Tick> ticks;
    for (double value = std::ceil(low_ / step - 1e-9) * step; value <= high_ + 1e-9 * step;
         value += step) {
      ticks.push_back({value, number(value)});
    }
    return ticks;
  }

  const Axis& axis_;
  double length_;
  double low_;  // exponents on log scales
  double high_;
  double begin_;
};

// Room left of a panel.
double left_of(const Panel& panel) {
  if (panel.y.scale != Scale::names) return kAxisRoom;
  std::size_t longest = 0;
  for (const std::string& name : panel.y.names) longest = std::max(longest, name.size());
  return std::max(kAxisRoom, kNameLetter * static_cast<double>(longest) + 14);
}

std::string drawn_axes(const Panel& panel, const Ruler& x, const Ruler& y, glm::dvec2 origin) {
  const std::string faint = "stroke=\"#eeeeee\"";
  const std::string grid = "stroke=\"#d4d4d4\"";
  const std::string frame = "stroke=\"#444444\"";
  const glm::dvec2 right(kPanelWidth, 0.0);
  const glm::dvec2 up(0.0, -kPanelHeight);
  std::string faint_lines, lines, labels;
  for (const Tick& tick : x.ticks()) {
    const auto at = x.at(tick.value);
    if (!at) continue;
    const glm::dvec2 foot = origin + glm::dvec2(*at, 0.0);
    (tick.label.empty() ? faint_lines : lines) +=
        line_between(foot, foot + up, tick.label.empty() ? faint : grid);
    labels += text_at(foot + glm::dvec2(0, 16), tick.label, "text-anchor=\"middle\"");
  }
  for (const Tick& tick : y.ticks()) {
    const auto at = y.at(tick.value);
    if (!at) continue;
    const glm::dvec2 foot = origin - glm::dvec2(0.0, *at);
    (tick.label.empty() ? faint_lines : lines) +=
        line_between(foot, foot + right, tick.label.empty() ? faint : grid);
    labels += text_at(foot + glm::dvec2(-7, 4), tick.label, "text-anchor=\"end\"");
  }
  std::string out = faint_lines + lines;
  for (const auto& [from, to] :
       {std::pair(origin, origin + right), std::pair(origin, origin + up)}) {
    out += line_between(from, to, frame);
  }
  // What lies below the break is 0, however far down a log scale would have to reach.
  if (y.begin() > 0.0) {
    const glm::dvec2 at = origin - glm::dvec2(0.0, y.begin());
    out += line_between(at, at + right, frame + dashes(Line::dotted));
  }
  if (x.begin() > 0.0) {
    const glm::dvec2 at = origin + glm::dvec2(x.begin(), 0.0);
    out += line_between(at, at + up, frame + dashes(Line::dotted));
  }
  out += labels;
  out += text_at(origin + glm::dvec2(kPanelWidth / 2, 38), panel.x.title, "text-anchor=\"middle\"");
  if (!panel.y.title.empty()) {
    const glm::dvec2 at = origin + glm::dvec2(-left_of(panel) + 14, -kPanelHeight / 2);
    out += text_at({0, 0}, panel.y.title,
                   "text-anchor=\"middle\" transform=\"translate(" + number(at.x) + " " +
                       number(at.y) + ") rotate(-90)\"");
  }
  out += text_at(origin + up - glm::dvec2(0, 10), panel.title, "font-weight=\"bold\"");
  return out;
}

std::string drawn_series(const Series& series, const Ruler& x, const Ruler& y, glm::dvec2 origin) {
  std::string out, path, markers;
  std::optional<glm::dvec2> last;
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    const auto px = x.at(series.points[i].x);
    const auto py = y.at(series.points[i].y);
    if (!px || !py) continue;
    const glm::dvec2 at = origin + glm::dvec2(*px, -*py);
    path += (path.empty() ? "" : " ") + number(at.x) + "," + number(at.y);
    markers += marker_at(at, series.style);
    last = at;
    if (i >= series.x_ranges.size()) continue;
    const auto from = x.at(series.x_ranges[i].x);
    const auto to = x.at(series.x_ranges[i].y);
    if (from && to) {
      out +=
          line_between(origin + glm::dvec2(*from, -*py), origin + glm::dvec2(*to, -*py),
                       std::string("stroke=\"") + series.style.color + "\" stroke-width=\"1.4\"");
    }
  }
  if (series.style.line != Line::none && !path.empty()) {
    out += "<polyline points=\"" + path + "\" fill=\"none\" stroke=\"" + series.style.color +
           "\" stroke-width=\"1.8\"" + dashes(series.style.line) + "/>\n";
  }
  if (last && !series.label.empty()) {
    const double length = kNameLetter * static_cast<double>(series.label.size());
    const bool fits = last->x + 9 + length <= origin.x + kPanelWidth;
    const glm::dvec2 at = *last + (fits ? glm::dvec2(9, 4) : glm::dvec2(-8, -9));
    const std::string anchor = fits ? "text-anchor=\"start\" " : "text-anchor=\"end\" ";
    // White around the letters keeps them readable on lines; not every viewer knows paint-order.
    markers += text_at(at, series.label,
                       anchor + "stroke=\"white\" stroke-width=\"3.5\" stroke-linejoin=\"round\"");
    markers += text_at(at, series.label, anchor + "fill=\"" + series.style.color + "\"");
  }
  return out + markers;
}

}  // namespace

std::string to_svg(const Page& page) {
  const std::size_t in_row = page.panels_in_row > 0 ? static_cast<std::size_t>(page.panels_in_row)
                                                    : std::max<std::size_t>(1, page.panels.size());
  const std::size_t panel_rows =
      std::max<std::size_t>(1, (page.panels.size() + in_row - 1) / in_row);
  double width = 0.0;
  for (std::size_t first = 0; first < page.panels.size(); first += in_row) {
    double row = kMargin;
    for (std::size_t p = first; p < std::min(first + in_row, page.panels.size()); ++p) {
      row += left_of(page.panels[p]) + kPanelWidth + kMargin;
    }
    width = std::max(width, row);
  }
  const double top = kMargin + 30 + kLineHeight * static_cast<double>(page.notes.size()) + 26;
  const auto columns = static_cast<std::size_t>(std::max(1, page.legend_columns));
  const std::size_t rows = (page.legend.size() + columns - 1) / columns;
  const double legend_top = top + static_cast<double>(panel_rows) * (kPanelHeight + kBelow + 14) +
                            static_cast<double>(panel_rows - 1) * kAbove;
  const double height = legend_top + kLineHeight * static_cast<double>(rows) + kMargin / 2;
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + number(width) +
                    "\" height=\"" + number(height) + "\" viewBox=\"0 0 " + number(width) + " " +
                    number(height) +
                    "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"12\" "
                    "fill=\"#222222\">\n";
  out += "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  out += text_at({kMargin, kMargin + 14}, page.title, "font-size=\"18\" font-weight=\"bold\"");
  for (std::size_t i = 0; i < page.notes.size(); ++i) {
    out += text_at({kMargin, kMargin + 36 + kLineHeight * static_cast<double>(i)}, page.notes[i],
                   "fill=\"#555555\"");
  }
  double left = kMargin;
  for (std::size_t p = 0; p < page.panels.size(); ++p) {
    const Panel& panel = page.panels[p];
    if (p % in_row == 0) left = kMargin;
    const double row_top =
        top + static_cast<double>(p / in_row) * (kPanelHeight + kBelow + 14 + kAbove);
    const glm::dvec2 origin(left + left_of(panel), row_top + kPanelHeight);
    const Ruler x(panel.x, kPanelWidth, false);
    const Ruler y(panel.y, kPanelHeight, true);
    out += drawn_axes(panel, x, y, origin);
    for (const Series& series : panel.series) out += drawn_series(series, x, y, origin);
    left += left_of(panel) + kPanelWidth + kMargin;
  }
  const double column_width = (width - 2 * kMargin) / static_cast<double>(columns);
  for (std::size_t i = 0; i < page.legend.size(); ++i) {
    const LegendEntry& entry = page.legend[i];
    if (entry.text.empty()) continue;
    // Down the columns, so that entries that belong together stay together.
    const glm::dvec2 at(kMargin + column_width * static_cast<double>(i / rows),
                        legend_top + kLineHeight * static_cast<double>(i % rows));
    if (entry.style.line != Line::none) {
      out += line_between(at, at + glm::dvec2(26, 0),
                          std::string("stroke=\"") + entry.style.color + "\" stroke-width=\"1.8\"" +
                              dashes(entry.style.line));
    }
    out += marker_at(at + glm::dvec2(13, 0), entry.style);
    out += text_at(at + glm::dvec2(34, 4), entry.text, "text-anchor=\"start\"");
  }
  return out + "</svg>\n";
}

Decades decades_around(const std::vector<double>& values) {
  double low = INFINITY;
  double high = 0.0;
  for (const double value : values) {
    if (!(value > 0.0) || !std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (high == 0.0) return {1.0, 10.0};
  const double decade = std::floor(std::log10(low) + 1e-9);
  return {std::pow(10.0, decade),
          std::pow(10.0, std::max(decade + 1.0, std::ceil(std::log10(high) - 1e-9)))};
}

}  // namespace maille::plot
