#include "app/command_line.h"

#include <charconv>
#include <cstdio>
#include <map>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "app/byte_size.h"
#include "app/commands.h"
#include "app/document.h"
#include "core/failure.h"
#include "core/trace.h"
#include "measure/stability_case.h"
#include "volume/phantom.h"

namespace maille {
namespace {

// "512x512x333" -> three numbers; nullopt unless there are exactly `count`, each 1 .. highest.
std::optional<std::vector<int>> numbers_between_x(std::string_view text, std::size_t count,
                                                  int highest) {
  std::vector<int> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    int number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc() || number < 1 || number > highest) return std::nullopt;
    numbers.push_back(number);
    if (next == end) break;
    if (*next != 'x') return std::nullopt;
    at = next + 1;
  }
  if (numbers.size() != count) return std::nullopt;
  return numbers;
}

void add_picture_size(CLI::App& command, PictureSize& size) {
  command
      .add_option_function<std::string>(
          "--size",
          [&size](const std::string& text) {
            const auto numbers = numbers_between_x(text, 2, 16384);
            if (!numbers) throw CLI::ValidationError("--size", "expected WxH, got " + text);
            size = {(*numbers)[0], (*numbers)[1]};
          },
          "Width and height of the picture in pixels (default 512x512)")
      ->type_name("WxH");
}

template <class Bytes>
void add_byte_size(CLI::App& app, const std::string& name, Bytes& bytes,
                   const std::string& description) {
  app.add_option_function<std::string>(
         name,
         [&bytes, name](const std::string& text) {
           const auto size = parse_byte_size(text);
           if (!size) {
             throw CLI::ValidationError(
                 name, "expected a number of bytes such as 512M or 2G, got " + text);
           }
           bytes = *size;
         },
         description)
      ->type_name("SIZE");
}

constexpr const char* kGlobalOptions = "Options of every command";

// They belong to the program; the help of each command lists them too.
void list_global_options(const CLI::App& app, CLI::App& command) {
  const auto options = app.get_options(
      [](const CLI::Option* option) { return option->get_group() == kGlobalOptions; });
  const auto group = CLI::Formatter().make_group(kGlobalOptions, false, options);
  command.footer(group.substr(group.find_first_not_of('\n')));
}

void add_global_options(CLI::App& app, GlobalOptions& global) {
  static const std::map<std::string, gpu::Store> kStores = {{"auto", gpu::Store::automatic},
                                                            {"sparse", gpu::Store::sparse},
                                                            {"dense", gpu::Store::dense}};
  app.option_defaults()->group(kGlobalOptions);
  app.add_option("--device", global.device,
                 "Vulkan device: its number in --list-devices or a part of its name");
  app.add_option("--volume-store", global.store,
                 "auto: sparse images on GPUs that have them, one dense image elsewhere")
      ->transform(CLI::CheckedTransformer(kStores).description(""))
      ->type_name("auto|sparse|dense");
  app.add_option("--threads", global.threads, "Worker threads (default: one a hardware thread)")
      ->check(CLI::Range(1, 1024).description(""))
      ->type_name("N");
  app.add_option_function<std::string>(
         "--seed",
         [&global](const std::string& text) {
           const char* const end = text.data() + text.size();
           const auto [next, error] = std::from_chars(text.data(), end, global.seed);
           if (error == std::errc() && next == end) return;
           throw CLI::ValidationError("--seed",
                                      "expected a whole number from 0 to 2^64 - 1, got " + text);
         },
         "Seed of formula volumes that name none (default 1)")
      ->type_name("N");
  app.add_flag("--deterministic", global.deterministic,
               "Time decides nothing: a relaxation ends when it has converged or after " +
                   std::to_string(kDeterministicIterations) +
                   " iterations, whatever at_most_seconds says; the same input gives the same "
                   "bits for any number of threads");
  add_byte_size(app, "--lattice-memory", global.lattice_memory_bytes,
                "What displacements may take in memory, those of undo steps included; the rest "
                "goes to a scratch file, and what moves at once must fit (default: no limit). "
                "Relaxation takes what the lattice leaves of it, or a quarter of the machine's "
                "memory without it, and relaxes what surrounds the drag where that is too little");
  add_byte_size(app, "--undo-memory", global.undo_memory_bytes,
                "What undo may hold; the oldest steps beyond it are dropped (default 1G)");
  app.add_flag("--quiet", global.quiet, "Say only what went wrong");
  app.add_flag("--verbose", global.verbose, "Say on stderr what is used and what is left out");
  app.option_defaults()->group("Options");
}

struct Words {
  GlobalOptions global;
  RenderOptions render;
  DeformOptions deform;
  PickOptions pick;
  InfoOptions info;
  PhantomOptions phantom;
  DemoOptions demo;
  MeasureOptions measure;
  WindowCommandOptions window;
  bool list_devices = false;
};

constexpr const char* kInput =
    "A volume (.nrrd, .nhdr, .mha, .mhd, NAME_XxYxZ_TYPE.raw) or a scene "
    "(.json)";

void add_render(CLI::App& app, RenderOptions& o) {
  auto& command = *app.add_subcommand("render", "Play a scene and write the picture of its end");
  command.add_option("INPUT", o.input, kInput)->required();
  command.add_option("-o,--output", o.output, "The picture, PNG")->required()->type_name("FILE");
  add_picture_size(command, o.size);
  command.add_option("--frames", o.frames, "Write a picture a step into this folder too")
      ->type_name("DIR");
  command.add_option("--stats", o.stats, "Write what it took, as JSON")->type_name("FILE");
  command.add_option("--trace", o.trace, "Write a Chrome trace of it, as JSON")->type_name("FILE");
}

void add_deform(CLI::App& app, DeformOptions& o) {
  auto& command =
      *app.add_subcommand("deform", "Play a scene and write the deformed volume; needs no Vulkan");
  command.add_option("INPUT", o.input, kInput)->required();
  command.add_option("-o,--output", o.output, "The volume, .nrrd or .mha")
      ->required()
      ->type_name("FILE");
  command
      .add_option("--field", o.field,
                  "Write the displacement in mm from each voxel of the output to where its value "
                  "came from in the input: x_in = x_out + field(x_out)")
      ->type_name("FILE");
  command
      .add_option("--extent", o.extent,
                  "grow: as many more voxels as hold all that was pulled out of the volume; keep: "
                  "the volume's own")
      ->transform(CLI::CheckedTransformer(std::map<std::string, SavedExtent>{
          {"grow", SavedExtent::grow}, {"keep", SavedExtent::keep}}))
      ->default_str("grow")
      ->type_name("grow|keep");
  command
      .add_option("--forward-field", o.forward_field,
                  "Write the displacement in mm of each voxel of the input")
      ->type_name("FILE");
  command.add_option("--stats", o.stats, "Write what it took, as JSON")->type_name("FILE");
  command.add_option("--trace", o.trace, "Write a Chrome trace of it, as JSON")->type_name("FILE");
}

void add_pick(CLI::App& app, PickOptions& o) {
  auto& command = *app.add_subcommand(
      "pick", "Play a scene and print what is seen at a pixel, as JSON; null for nothing");
  command.add_option("INPUT", o.input, kInput)->required();
  command.add_option("X", o.pixel.x, "Pixels from the left")->required();
  command.add_option("Y", o.pixel.y, "Pixels from the top")->required();
  add_picture_size(command, o.size);
}

void add_info(CLI::App& app, InfoOptions& o) {
  auto& command = *app.add_subcommand("info", "Print what a volume file holds");
  command.add_option("FILE", o.file, "A volume")->required();
  command.add_flag("--json", o.json, "As JSON, histogram included");
}

void add_phantom(CLI::App& app, PhantomOptions& o) {
  std::string names;
  for (const auto name : phantom_names()) names += (names.empty() ? "" : ", ") + std::string(name);
  auto& command = *app.add_subcommand("phantom", "Write a volume made from a formula");
  command.add_option("NAME", o.name, names)->required();
  command
      .add_option_function<std::string>(
          "--size",
          [&o](const std::string& text) {
            const auto numbers = numbers_between_x(text, 3, 65536);
            if (!numbers) throw CLI::ValidationError("--size", "expected XxYxZ, got " + text);
            o.size = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
          },
          "Voxels along each axis")
      ->required()
      ->type_name("XxYxZ");
  command.add_option("-o,--output", o.output, "The volume, .nrrd or .mha")
      ->required()
      ->type_name("FILE");
}

void add_demo(CLI::App& app, DemoOptions& o) {
  auto& command = *app.add_subcommand(
      "demo", "Pull the nose of a head and write pictures of it: what to run first");
  command.add_option("INPUT", o.input, "A volume or a scene; without one, a built-in head");
  command.add_option("-o,--output", o.output, "Folder for the pictures (default out/demo)")
      ->type_name("DIR");
  add_picture_size(command, o.size);
}

void add_measure(CLI::App& app, MeasureOptions& o) {
  auto& command = *app.add_subcommand(
      "measure", "Measure Maille on this machine: JSON, CSV and a plot, and a table to read");
  command.require_subcommand(1);
  command.fallthrough();
  const auto add_output = [&o](CLI::App& what) {
    what.add_option("-o,--output", o.output, "Folder for the pages")->required()->type_name("DIR");
  };
  auto& speed = *command.add_subcommand(
      "speed",
      "How fast a drag is answered, by elements, material, volume and threads (1 and 2, or "
      "--threads)");
  add_output(speed);
  auto& error =
      *command.add_subcommand("error", "Run time against error, beside other ways to do the same");
  error.add_option("--stage", o.stage, "Of the deformation: chainmail, relaxation or resample")
      ->required()
      ->type_name("STAGE");
  error.add_option("--elements", o.elements, "relaxation: of its scenes (default 100000 2000000)")
      ->check(CLI::Range(std::int64_t{1000}, std::int64_t{20'000'000}))
      ->type_name("N");
  error.add_option("--head", o.head, "relaxation: a CT scan whose nose is pulled, facing -y")
      ->type_name("VOLUME");
  error.add_option("--edge", o.volume_edge, "resample: of its volumes, voxels (default 128)")
      ->check(CLI::Range(32, 192).description(""))
      ->type_name("N");
  add_output(error);
  auto& frame = *command.add_subcommand(
      "frame", "How fast pictures come: by mode and volume, and after a change");
  add_picture_size(frame, o.picture);
  add_output(frame);
  auto& stability = *command.add_subcommand(
      "stability",
      "Whether a drag or its relaxation ever goes wrong: stiffness, limits, drags, spacings, thin "
      "and cut and folded volumes, each to its ends; exit code 1 where it does");
  stability.add_option("--groups", o.groups, "Of the cases, divided by commas (default: all)")
      ->delimiter(',')
      ->check(CLI::IsMember(stability_groups()))
      ->type_name("NAME,...");
  stability.add_option("--edge", o.edge, "Of the blocks, voxels (default 12)")
      ->check(CLI::Range(8, 64).description(""))
      ->type_name("N");
  add_output(stability);
}

int say(const Error& error) {
  std::fprintf(stderr, "maille: error: %s\n", error.message.c_str());
  return static_cast<int>(error.kind);
}

Result<void> run(const CLI::App& app, const Words& words) {
  const auto commands = app.get_subcommands();
  if (words.list_devices) {
    if (commands.empty() && words.window.input.empty()) return list_devices();
    return Error{ErrorKind::usage, "--list-devices: expected nothing beside it"};
  }
  if (commands.empty()) return run_window_command(words.window, words.global);
  const auto name = commands[0]->get_name();
  if (!words.window.input.empty()) {
    // A command's surplus word ends up at the program's own positional.
    return Error{ErrorKind::usage, name + ": one word too many: " + words.window.input.string()};
  }
  if (!words.render.trace.empty() || !words.deform.trace.empty()) trace::start();
  if (name == "render") return run_render(words.render, words.global);
  if (name == "deform") return run_deform(words.deform, words.global);
  if (name == "pick") return run_pick(words.pick, words.global);
  if (name == "info") return run_info(words.info, words.global);
  if (name == "phantom") return run_phantom(words.phantom, words.global);
  if (name == "measure") {
    const auto page = commands[0]->get_subcommands()[0]->get_name();
    if (page == "speed") return run_measure_speed(words.measure, words.global);
    if (page == "error") return run_measure_error(words.measure, words.global);
    if (page == "frame") return run_measure_frame(words.measure, words.global);
    return run_measure_stability(words.measure, words.global);
  }
  return run_demo(words.demo, words.global);
}

}  // namespace

int run_command_line(int argc, const char* const* argv) try {
  Words words;
  CLI::App app("Maille: drag, stretch and ray cast large scan volumes, voxel by voxel.", "maille");
  app.set_version_flag("--version", std::string("maille ") + MAILLE_VERSION);
  app.add_flag("--list-devices", words.list_devices, "Print the Vulkan devices of this machine");
  app.add_option("INPUT", words.window.input,
                 "Opened in a window: a volume or a scene, whose actions are not played there; "
                 "without one, a built-in head");
  add_global_options(app, words.global);
  app.require_subcommand(0, 1);
  app.fallthrough();
  add_render(app, words.render);
  add_deform(app, words.deform);
  add_pick(app, words.pick);
  add_info(app, words.info);
  add_phantom(app, words.phantom);
  add_demo(app, words.demo);
  add_measure(app, words.measure);
  for (auto* const command : app.get_subcommands({})) {
    list_global_options(app, *command);
    for (auto* const part : command->get_subcommands({})) list_global_options(app, *part);
  }
  app.footer(
      "Exit codes: 0 done, 1 failed while running, 2 wrong usage, 3 bad input, 4 no usable "
      "device or device lost, 5 out of memory or over budget, 6 file system error.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    std::string command = "maille";
    std::string what = error.what();
    for (auto chosen = app.get_subcommands(); !chosen.empty();) {
      command += " " + chosen[0]->get_name();
      const CLI::App& last = *chosen[0];
      chosen = last.get_subcommands();
      const auto parts = last.get_subcommands({});
      if (!chosen.empty() || parts.empty()) continue;
      what = last.get_name() + ": expected one of";
      for (const auto* const part : parts) {
        what += (part == parts[0] ? " " : ", ") + part->get_name();
      }
    }
    return say({ErrorKind::usage, what + " (" + command + " --help)"});
  }
  if (const auto done = run(app, words); !done) return say(done.error());
  if (std::fflush(stdout) != 0) {
    return say({ErrorKind::file_system, "standard output could not be written"});
  }
  return 0;
} catch (const Failure& failure) {
  return say(failure.error());
} catch (const std::bad_alloc&) {
  return say({ErrorKind::out_of_memory, "out of memory"});
} catch (const std::length_error&) {
  return say({ErrorKind::out_of_memory, "out of memory"});
} catch (const std::exception& error) {
  return say({ErrorKind::failed, error.what()});
}

}  // namespace maille
