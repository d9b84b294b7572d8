// What the keys and buttons of the window do: the one list that the help on the screen shows. The
// README's table is the same.
#pragma once

#include <array>

namespace maille {

struct Binding {
  const char* input;
  const char* action;
};

inline constexpr std::array<Binding, 17> kBindings = {{
    {"left drag on the volume", "grab and pull"},
    {"left drag on the background", "turn"},
    {"Alt + left drag", "turn, wherever the pointer is"},
    {"middle or Shift + left drag", "pan"},
    {"right drag, wheel", "zoom"},
    {"Ctrl + left drag", "roll"},
    {"+ and -", "larger and smaller grab"},
    {"Esc", "let the drag never have happened"},
    {"Delete", "release all pins"},
    {"Ctrl + Z, Ctrl + Shift + Z", "undo, redo"},
    {"Space", "pause and resume relaxation"},
    {"M", "read the materials again from the scene file"},
    {"I", "first surface / transfer function"},
    {"Enter", "whole volume from the front"},
    {"F12", "save the picture"},
    {"H", "show and hide this help"},
    {"Q", "quit"},
}};

}  // namespace maille
