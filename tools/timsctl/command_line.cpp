#include "tools/timsctl/command_line.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.h"
#include "tools/cli/service.h"

namespace timsctl {

namespace {

constexpr Verb kOwnVerbs[] = {
    {"status", "", "", 0, 0, kShowOptions, false,
     "One screen: who the router is, what it carries, what it dropped.", "timsctl status -w",
     status, kRows},

    {"router", "show", "", 0, 0, kShowOptions, false,
     "Who the router is: name, address, version, where it listens.", "timsctl router -j",
     router_show, kRows},
    {"router", "clients", "", 0, 0, kShowOptions, false,
     "Everybody attached to the router, with the bytes in and out.",
     "timsctl router clients --sort drops", router_clients, kRows},

    {"router", "list", "", 0, 0, kShowOptions, false,
     "All routers of the fleet as a tree: who is there, how far, whose clock is off. Exit status "
     "6: "
     "one that should be there did not answer.",
     "timsctl router list", router_list, kRows},

    {"link", "show", "[NAME]", 0, 1, kShowOptions, false,
     "Links to other routers: state, round trip, loss, rates, queues, what was dropped.",
     "timsctl link show robot1 -o wide", link_show, kRows},
    {"link", "up", "NAME", 1, 1, "", false, "Lets a link that was taken down come up again.",
     "timsctl link up robot1", link_up},
    {"link", "down", "NAME", 1, 1, "yes", false,
     "Takes a link down: its mailboxes are withdrawn, and it stays down until `link up`.",
     "timsctl link down robot1", link_down},
    {"link", "reset", "NAME", 1, 1, "", false, "Ends a link's session and begins a new one.",
     "timsctl link reset robot1", link_reset},

    {"fleet", "show", "", 0, 0, kShowOptions, false,
     "Routers that announce themselves in the fleet (by DDS), with their addresses, and how DDS "
     "itself is.",
     "timsctl fleet show", fleet_show, kRows},
    {"fleet", "server", "[ADDRESS:PORT]", 0, 1, "", false,
     "Runs a discovery server, of Fast DDS, until Ctrl-C: routers with dds.server set to it find "
     "each other without multicast. 0.0.0.0:11811 unless given.",
     "timsctl fleet server 10.9.1.1:11811", fleet_server},

    {"route", "show", "[GLOB]", 0, 1, "watch count once sort all-routers", false,
     "Every registered address: through which port or link, to whom. -a: at every router.",
     "timsctl route show 'Ladar(*/0)'", route_show, kRows},
    {"route", "add", "GLOB ROUTER", 2, 2, "", false,
     "Until the router ends: addresses that nobody has registered go to this neighbour.",
     "timsctl route add 'Ladar(3/*)' robot3", route_add},
    {"route", "del", "GLOB [ROUTER]", 1, 2, "", false, "Takes such a route away.",
     "timsctl route del 'Ladar(3/*)'", route_del},
    {"route", "get", "ADDR", 1, 1, "from type", false,
     "Asks the code that forwards where a message would go. Exit status 0: delivered, 1: not.",
     "timsctl route get Ladar/3/0 --from Pilot/3/0 --type get_data", route_get, kRows},
    {"route", "watch", "[GLOB]", 0, 1, "count once for", true, "Registrations as they come and go.",
     "timsctl route watch 'Camera(*/*)'", route_watch},

    {"mbx", "list", "[GLOB]", 0, 1, kShowOptions, false,
     "Mailboxes: owner, what waits, what was replaced or refused.",
     "timsctl mbx list Ladar --sort replaced", mbx_list, kRows},
    {"mbx", "show", "ADDR", 1, 1, kShowOptions, false, "All about one mailbox.",
     "timsctl mbx show Ladar/3/0", mbx_show, kRows},

    {"component", "list", "[GLOB]", 0, 1, "watch count once sort wait all-routers", false,
     "Components, and whether they are on: all that have a mailbox here or behind a link; when "
     "none "
     "of them fits GLOB, and with -a, those of every router of the fleet. --wait: until there is "
     "one.",
     "timsctl component list 'Ladar(*/*)'", component_list, kRows},
    {"component", "status", "ADDR...", 1, 64, "wait", false,
     "Whether components are on. Exit status 1: one is not. --wait: until all are.",
     "timsctl component status Chassis/1/0 Pilot/1/0", component_status, kRows},
    {"component", "show", "ADDR", 1, 1, "", false,
     "All about one component: since when it is on, its parameters, who gets its data, and where "
     "it was not in real time (components with a real-time priority watch themselves, others when "
     "they are started with RACK_WATCH=1).",
     "timsctl component show Chassis/1/0", component_show},
    {"component", "on", "ADDR...", 1, 64, "wait", false,
     "Turns components on, one after the other, and waits until each has done so. --wait: tries "
     "again when one is not there yet or says no.",
     "timsctl component on Pilot/1/1 --wait", component_on},
    {"component", "off", "ADDR...", 1, 64, "no-wait wait", false,
     "Turns components off, and waits until they are.", "timsctl component off Pilot/1/1",
     component_off},
    {"component", "param", "get|set|save ADDR [NAME] [VALUE]", 2, 4, "wait dry-run", false,
     "Parameters of a component: all, one, or a new value for one, and when it takes effect. save "
     "writes those that were set since `timsctl up` started it (or the one called NAME) into the "
     "robot's file, whose comments and order stay; here, where that robot runs.",
     "timsctl component param set Chassis/1/0 vxMax 500", component_param, kRows},
    {"component", "data", "ADDR", 1, 1, "body-max wait si", false,
     "The newest data of a component, field by field. --wait: until it has some.",
     "timsctl component data Position/1/0", component_data, kLines},
    {"component", "pilot", "CHASSIS [PILOT|none]", 1, 2, "wait", false,
     "Which pilot may drive a chassis; with PILOT: it may from now on, and no other.",
     "timsctl component pilot Chassis/1/0 Pilot/1/1", component_pilot},

    {"log", "show", "", 0, 0, "component level since until count once directory", false,
     "What components have said, from the files of gdos-log on this host; needs no router. -n: the "
     "newest. Exit status 1: nothing.",
     "timsctl log show -c 'Chassis(*/*)' -l warning -S 10min", log_show},
    {"log", "follow", "[ADDR]", 0, 1, "component level count once for", true,
     "What components say: time, who, how important, and the words. From gdos-log where it runs, "
     "also on another robot (ADDR); else from the components themselves, and then only one program "
     "can listen.",
     "timsctl log follow GDOS/3/1 -l warning", log_follow},

    {"ping", "", "ADDR|router", 1, 1, "count once for interval size priority hops", false,
     "Round trips to a component or a router. A component is asked GET_STATUS, a router (`router`, "
     "or an address such as Tims/1/1) the admin ping; 4 times unless -n or --for says otherwise. "
     "--hops: to every router on the way first.",
     "timsctl ping Ladar/3/0 -n 10 -i 100ms", ping},

    {"explain", "", "SRC DST", 2, 2, "type", false,
     "Asks every router on the way what it would do with a message; the last line is the cause and "
     "what to do. Exit status 0: it arrives, 1: not.",
     "timsctl explain Pilot/1/0 Ladar/2/0", explain},
    {"trace", "", "ADDR", 1, 1, "type priority", false,
     "Sends GET_STATUS with the TRACE flag: every router on the way tells when it passed and how "
     "long it had waited.",
     "timsctl trace Ladar/2/0", trace},
    {"clock", "", "", 0, 0, kShowOptions, false,
     "Every router's clock against the first one's, from the keep-alives of the links.",
     "timsctl clock", clock, kRows},

    {"msg", "pub", "ADDR [TYPE] [FIELD=VALUE...] [-]", 1, 256,
     "hex file raw rate count once for priority yes no-wait fields si", false,
     "Sends a message: by its name with fields (those that are not given are as in its struct), as "
     "bytes, or what `msg echo --raw` or --json wrote. Numbers are in the units of `msg show`, or "
     "have one: vx=0.2m/s. A command (TYPE > 0) that is sent once waits for its answer. Asks first "
     "when ADDR moves something.",
     "timsctl msg pub Chassis/0/0 move vx=200 omega=0.1", msg_pub},
    {"msg", "echo", "[ADDR...]", 0, 64,
     "listen count once for period body-max priority raw fields si filter", true,
     "Prints the data of a component as it comes, a line a message. Subscribes with GET_CONT_DATA "
     "and ends that when it ends; with --listen, registers an address and prints what comes there. "
     "--raw and --json are valid input of `msg pub -f`.",
     "timsctl msg echo Chassis/0/0 --si --filter 'vx>0.1'", msg_echo, kLines},
    {"msg", "types", "[CLASS|every]", 0, 1, "", false,
     "The messages of a class, or of all: numbers, names, bodies. `every`: those that every "
     "component understands. Needs no router.",
     "timsctl msg types Chassis", msg_types, kRows},
    {"msg", "show", "CLASS NAME", 2, 2, "", false,
     "The fields of a message, with their units. Needs no router.", "timsctl msg show Chassis move",
     msg_show, kRows},
    {"msg", "hz", "ADDR...", 1, 64, "count once for interval period body-max", true,
     "How often messages come, side by side. -n counts reports.",
     "timsctl msg hz Ladar/3/0 Odometry/3/0 --for 10s", msg_hz, kRows},
    {"msg", "bw", "ADDR...", 1, 64, "count once for interval period body-max", true,
     "How many bytes come, side by side. -n counts reports.", "timsctl msg bw Camera/3/0 --once",
     msg_bw, kRows},

    {"top", "", "", 0, 0, "count once for interval sort", true,
     "Clients and their rates, live. Keys: q quits, left and right choose the column.",
     "timsctl top --sort in/s", top, kRows},
    {"stats", "", "", 0, 0, "watch count once sort by", false,
     "What became of messages, by port, class and outcome; of those in local mailboxes.",
     "timsctl stats --by reason", stats, kRows},

    {"config", "show", "", 0, 0, "watch count once sort origin", false,
     "The values the router runs with.", "timsctl config show --origin", config_show, kRows},
    {"config", "check", "FILE", 1, 1, "", false,
     "Reads a configuration as the router would. Exit status 1: it has errors.",
     "timsctl config check /etc/tims/router.toml", config_check},

    {"device", "list", "", 0, 0, "sort", false,
     "What is plugged into this host: serial ports, CAN interfaces, cameras, sticks, lines. Which "
     "of our programs drives it, the address for its --device, and what is missing: rights, a "
     "module of the kernel, or who has it. Needs no router.",
     "timsctl device list", device_list, kRows},
    {"device", "watch", "", 0, 0, "count once for", true,
     "Devices as they are plugged in and pulled out. Needs no router.", "timsctl device watch",
     device_watch},
    {"device", "record", "DEVICE FILE", 2, 2, "count once for", true,
     "Records what comes from a device that no program uses, as drivers do with --record: for "
     "--device=play:FILE. A device that is pulled out is waited for.",
     "timsctl device record 'serial:/dev/ttyUSB0?baud=9600' gps.cap --for 1min", device_record},
    {"device", "play", "FILE [DEVICE]", 1, 2, "for", false,
     "What is in a recording (ours, candump's, pcap, raw bytes): records, bytes, gaps, events. "
     "With DEVICE (pty:PATH, tcp:127.0.0.1:PORT, udp:HOST:PORT, can:INTERFACE): plays it there, in "
     "the place of its device. FILE?speed=max plays without waiting, ?loop=1 again and again, "
     "?port=N one port of a packet capture.",
     "timsctl device play gps.cap pty:/tmp/gps", device_play},

    {"world", "show", "", 0, 0, "watch count once sort world body-max", false,
     "What is true in a simulated world: where robots and people are, what robots have touched, "
     "what is pulled out of them.",
     "timsctl world -w", world_show, kRows},
    {"world", "place", "ROBOT X Y [RHO]", 3, 4, "world si", false,
     "Puts a robot elsewhere: mm to the north and to the east, rad clockwise from north; or with a "
     "unit, as 1.5m.",
     "timsctl world place scout 1500 -2000 1.57", world_place},
    {"world", "put", "X Y RADIUS", 3, 3, "world si", false,
     "Puts a post into the world, 1 m high, and prints its number.", "timsctl world put 4m 0 200",
     world_put},
    {"world", "remove", "ID", 1, 1, "world", false, "Takes it away again.",
     "timsctl world remove 3", world_remove},
    {"world", "people", "on|off", 1, 1, "world", false,
     "off: all people stand still until they are turned on.", "timsctl world people off",
     world_people},
    {"world", "unplug", "ROBOT SENSOR", 2, 2, "world", false,
     "Pulls a device out of its line, as somebody pulls a cable; `base` is what drives the robot.",
     "timsctl world unplug scout laser", world_unplug},
    {"world", "plug", "ROBOT SENSOR", 2, 2, "world", false, "Plugs it in again.",
     "timsctl world plug scout laser", world_plug},

    {"nav", "where", "[ROBOT]", 0, 1, "robot watch count once", false,
     "Where a robot is: x (north) and y (east), heading, how sure it is of that, and who says so; "
     "what is missing, and what to do about it. Exit status 1: it does not know.",
     "timsctl nav where", nav_where},
    {"nav", "goto", "X Y [HEADING]", 2, 3, "robot gps no-wait for patience", false,
     "Sends a robot to a place on its map, in m and degrees (clockwise from x), and shows how it "
     "gets on until it is there: turns on what is needed for that and off the pilot that was "
     "driving. Without HEADING it arrives as it comes. Ctrl-C, the end of --for and whatever "
     "keeps it from going on stop the robot. Exit status 0: it is there, 1: it is not, and why.",
     "timsctl nav goto 3.5 6 180", nav_goto},
    {"nav", "path", "[ROBOT]", 0, 1, "robot watch count once sort plot", false,
     "The path that a robot follows: lines and arcs, with lengths, radii and speeds.",
     "timsctl nav path --plot path.svg", nav_path, kRows},
    {"nav", "map", "[show|load] [FILE]", 0, 2, "robot plot", false,
     "Which maps a robot's components use. load: another one, a floor plan (.dxf) or a map of ROS "
     "(.yaml, a file of the robot's host), for all that take one: at once, or at their next ON. "
     "Exit status 1: one of them refused it.",
     "timsctl nav map load floor.dxf", nav_map, kRows},
    {"nav", "plot", "PICTURE FILE...", 2, 64, "", false,
     "Draws drives that were recorded, as .svg or .png: maps (.yaml, .dxf), files of DatalogRec, "
     "logs of CARMEN, what `mcl-eval --poses` and `msg echo -o csv` write, any columns with names; "
     "errors, where one of them is the truth. NAME=FILE gives a track its name. Needs no router.",
     "timsctl nav plot drive.png map.yaml position_0.dat truth=truth.csv", nav_plot},

    {"doctor", "", "", 0, 0, "format", false,
     "Looks for what usually goes wrong. Exit status 1: something did; 3: no router. --format "
     "nagios exits with 0 to 3, as monitoring expects.",
     "timsctl doctor", doctor},
    {"errors", "", "[CODE]", 0, 1, "", false,
     "What an error code, reason or finding means, and what to do.", "timsctl errors no_route",
     errors, kRows},
    {"completion", "", "bash|zsh|fish", 1, 1, "", false,
     "A script for the shell: completes verbs and living addresses.",
     "source <(timsctl completion bash)", completion},
    {"__complete", "", "WORD...", 0, 1000, "", false, "", "", complete},
};

std::vector<std::string_view> nouns() {
  std::vector<std::string_view> names;
  for (const Verb& verb : verbs())
    if (!verb.example.empty() && (names.empty() || names.back() != verb.noun))
      names.push_back(verb.noun);
  return names;
}

std::vector<std::string_view> verbs_of(std::string_view noun) {
  std::vector<std::string_view> names;
  for (const Verb& verb : verbs())
    if (verb.noun == noun) names.push_back(verb.verb);
  return names;
}

const Verb* find(std::string_view noun, std::string_view verb) {
  for (const Verb& row : verbs())
    if (row.noun == noun && row.verb == verb) return &row;
  return nullptr;
}

// The one name that begins with `word`.
std::string_view expand(std::string_view word, std::span<const std::string_view> names,
                        const std::string& what) {
  std::vector<std::string_view> fits;
  for (const std::string_view name : names) {
    if (name == word) return name;
    if (name.starts_with(word)) fits.push_back(name);
  }
  if (fits.size() == 1) return fits.front();
  if (fits.size() > 1)
    throw usage_error(fmt::format("\"{}\" may be {}", word, fmt::join(fits, ", ")),
                      "write one more letter");
  throw usage_error(fmt::format("no {} \"{}\"", what, word), nearest_hint(word, names));
}

// "Ladar(3/0)" and "0x03140000" are arguments, whatever verbs there are.
bool looks_like_verb(std::string_view word) {
  return std::ranges::all_of(word, [](char c) { return c >= 'a' && c <= 'z'; });
}

}  // namespace

std::span<const Verb> verbs() {
  static const std::vector<Verb> all = [] {
    std::vector<Verb> rows(std::begin(kOwnVerbs), std::end(kOwnVerbs));
    const auto more = program_verbs();
    rows.insert(rows.end(), more.begin(), more.end());
    return rows;
  }();
  return all;
}

Resolved resolve(std::span<const std::string> words) {
  if (words.empty()) return {};
  if (words[0] == "__complete") return {find(words[0], ""), words[0], 1};
  const std::string_view noun = expand(words[0], nouns(), "command");
  if (const Verb* only = find(noun, "")) return {only, noun, 1};
  const Verb* usual = find(noun, "show");
  if (usual == nullptr || usual->arguments_min > 0) usual = find(noun, "list");
  if (words.size() == 1) return {usual, noun, 1};
  if (!looks_like_verb(words[1]) && usual != nullptr) return {usual, noun, 1};
  const auto names = verbs_of(noun);
  return {find(noun, expand(words[1], names, std::string(noun) + " verb")), noun, 2};
}

// --- the command line

namespace {

// "--count=5", as split_words left it.
void set_option(const Verb& verb, std::string_view word, Options& options) {
  const std::size_t equals = std::min(word.find('='), word.size());
  const std::string_view name = word.substr(2, equals - 2);
  const std::string_view value = word.substr(std::min(equals + 1, word.size()));
  if (!is_in(name, verb.options) && !is_in(name, kGeneralOptions))
    throw usage_error(fmt::format("timsctl {} has no option --{}", verb.name(), name),
                      fmt::format("timsctl {} --help", verb.name()));
  find_option(name)->apply(options, value);
}

void check_form(const Verb& verb, Format format) {
  if (is_in(form_name(format), verb.forms)) return;
  std::string known(verb.forms);
  for (std::size_t at = 0; (at = known.find(' ', at)) != std::string::npos; at += 2)
    known.replace(at, 1, ", ");
  throw usage_error(fmt::format("timsctl {} has no -o {}", verb.name(), form_name(format)),
                    "it has " + known);
}

Text help_for(std::span<const std::string> words) {
  if (words.empty()) return {overview()};
  const Resolved found = resolve(words);
  const bool only_a_noun = words.size() == 1 && !is_single(found.noun);
  if (found.verb == nullptr || only_a_noun) return {noun_help(found.noun)};
  return {verb_help("timsctl " + found.verb->name(), *found.verb)};
}

bool contains(const std::vector<std::string>& words, std::string_view word) {
  return std::ranges::find(words, word) != words.end();
}

Exit become_own(Context& context) {
  become_verb(context.verb.program, context.verb.word(), context.options,
              context.options.arguments);
}

bool is_digit(char c) { return (c >= '0' && c <= '9') || c == '.'; }
// "-6"
bool is_number(std::string_view text) {
  return text.size() > 1 && std::ranges::all_of(text.substr(1), is_digit);
}

[[noreturn]] void refuse_unknown(std::string_view name) {
  std::vector<std::string_view> known;
  for (const OptionRow& row : option_table()) known.push_back(row.name);
  const auto near = base::nearest(name, known);
  throw usage_error("no option --" + std::string(name),
                    near ? "did you mean --" + std::string(*near) + "?" : "`timsctl --help`");
}

class Splitter {
 public:
  explicit Splitter(std::span<const std::string> arguments) : rest_(arguments) {}

  Words split() {
    while (!rest_.empty()) {
      const std::string_view token = take();
      if (token == "--") return with_the_rest();
      if (token.starts_with("--")) {
        take_long(token.substr(2));
      } else if (token.starts_with('-') && token.size() > 1 && !is_number(token)) {
        take_letters(token.substr(1));
      } else {
        out_.words.emplace_back(token);
        if (a_command_follows()) return with_the_rest();
      }
    }
    return std::move(out_);
  }

 private:
  Words with_the_rest() {
    out_.words.insert(out_.words.end(), rest_.begin(), rest_.end());
    return std::move(out_);
  }

  // "sim exec HOST COMMAND...": the options of another program are not ours.
  [[nodiscard]] bool a_command_follows() const {
    if (out_.words.size() != 3) return false;
    try {
      const Resolved found = resolve(out_.words);
      return found.verb != nullptr && found.words == 2 &&
             found.verb->arguments.ends_with("COMMAND...");
    } catch (const Failure&) {
      return false;  // said later, when all words are known
    }
  }

  std::string_view take() {
    const std::string_view token = rest_.front();
    rest_ = rest_.subspan(1);
    return token;
  }

  void take_long(std::string_view token) {
    const std::size_t equals = token.find('=');
    const std::string_view name = token.substr(0, equals);
    if (name == "help" || name == "version") {
      out_.options.push_back("--" + std::string(name));
      return;
    }
    const OptionRow* row = find_option(name);
    if (row == nullptr) refuse_unknown(name);
    if (equals == std::string_view::npos) return add(*row, {}, false);
    if (row->value.empty()) throw usage_error("--" + std::string(name) + " takes no value");
    add(*row, token.substr(equals + 1), true);
  }

  // "-jw", "-n5", "-n 5", "-jn5", "-w0.5"
  void take_letters(std::string_view letters) {
    for (; !letters.empty(); letters.remove_prefix(1)) {
      if (letters.front() == 'h') {
        out_.options.emplace_back("--help");
        continue;
      }
      const OptionRow* row = find_option(letters.front());
      if (row == nullptr)
        throw usage_error("no option -" + std::string(1, letters.front()), "`timsctl --help`");
      const bool attached = letters.size() > 1 && (row->takes_value() || is_digit(letters[1]));
      if (!row->value.empty() && attached) return add(*row, letters.substr(1), true);
      add(*row, {}, false);
    }
  }

  void add(const OptionRow& row, std::string_view value, bool given) {
    std::string option = "--" + std::string(row.name);
    if (!row.value.empty()) {
      if (!given && row.takes_value()) {
        if (rest_.empty()) throw usage_error(option + " needs a value: " + std::string(row.value));
        value = take();
      } else if (!given) {
        value = row.value.substr(1, row.value.size() - 2);  // "[2]": the default
      }
      option.append("=").append(value);
    }
    out_.options.push_back(std::move(option));
  }

  std::span<const std::string> rest_;
  Words out_;
};

}  // namespace

void become_verb(std::string_view program, const std::string& verb, const Options& options,
                 std::span<const std::string> arguments) {
  tims::os::Command command{std::string(program), verb};
  command.insert(command.end(), options.given.begin(), options.given.end());
  command.emplace_back("--");
  command.insert(command.end(), arguments.begin(), arguments.end());
  become({.command = std::move(command)});
}

std::variant<Command, Text> parse_command_line(std::span<const std::string> arguments) {
  if (!arguments.empty() && arguments[0] == "__complete") {
    Options options;
    options.arguments.assign(arguments.begin() + 1, arguments.end());
    if (const Verb* const verb = find(arguments[0], ""))
      return Command{verb, verb->run, std::move(options)};
  }
  Words words = split_words(arguments);
  if (contains(words.options, "--version")) return Text{version_text()};
  const bool help_word = !words.words.empty() && words.words.front() == "help";
  if (help_word || contains(words.options, "--help"))
    return help_for(std::span(words.words).subspan(help_word ? 1 : 0));

  if (words.words.empty()) words.words.emplace_back("status");
  const Resolved found = resolve(words.words);
  if (found.verb == nullptr)
    throw usage_error(fmt::format("timsctl {}: which verb?", found.noun),
                      fmt::format("timsctl {} --help", found.noun));
  Command command{found.verb, found.verb->run == nullptr ? become_own : found.verb->run, {}};
  for (const std::string& option : words.options) set_option(*found.verb, option, command.options);
  command.options.given = words.options;
  command.options.arguments.assign(words.words.begin() + static_cast<std::ptrdiff_t>(found.words),
                                   words.words.end());
  check_arguments("timsctl", found.verb->name(), *found.verb, command.options.arguments);
  check_form(*found.verb, command.options.format);
  return command;
}

Words split_words(std::span<const std::string> arguments) { return Splitter(arguments).split(); }

std::string version_text() { return fmt::format("timsctl {}\n", own_version()); }

bool is_single(std::string_view noun) { return find(noun, "") != nullptr; }

std::string overview() {
  std::string text =
      "timsctl NOUN [VERB] [ARGUMENTS] [OPTIONS]: asks a router and its components.\n"
      "Unique beginnings are enough (`timsctl mb li`); without a word it is `timsctl status`.\n\n";
  for (const Verb& verb : verbs())
    if (!verb.example.empty()) text += verb_line(verb.name(), verb);
  text += "\nGeneral options:\n" + option_lines(kGeneralOptions);
  text += "  -h, --help                    of a noun or verb: its options and an example\n";
  text +=
      "\nADDR is Ladar(3/0), Ladar/3/0 (needs no quotes), Ladar/3/0:2 or 0x03140000. A GLOB has *\n"
      "in any place: 'Ladar(*/0)', Ladar.\n"
      "Environment: TIMS_HOST as -H, TIMS_ROUTER the router of programs here, NO_COLOR.\n";
  return text.append(kExitHelp);
}

std::string noun_help(std::string_view noun) {
  std::string text = fmt::format("timsctl {} VERB\n", noun);
  for (const Verb& verb : verbs())
    if (verb.noun == noun) text += verb_line(verb.name(), verb);
  return text + fmt::format("More: timsctl {} VERB --help\n", noun);
}

}  // namespace timsctl
