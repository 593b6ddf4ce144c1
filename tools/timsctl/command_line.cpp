#include "tools/timsctl/command_line.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.h"
#include "tools/cli/service.h"

namespace timsctl {

namespace {

constexpr Verb kOwnVerbs[] = {
    {"status", "", "", 0, 0, kShowOptions, false,
     "Show a summary of the router: identity, traffic, dropped messages.", "timsctl status -w",
     status, kRows},

    {"router", "show", "", 0, 0, kShowOptions, false,
     "Show the identity of the router: name, address, version, listening sockets.",
     "timsctl router -j", router_show, kRows},
    {"router", "clients", "", 0, 0, kShowOptions, false,
     "List all clients of the router, with the bytes in and out.",
     "timsctl router clients --sort drops", router_clients, kRows},

    {"router", "list", "", 0, 0, kShowOptions, false,
     "Show all routers of the fleet as a tree: state, distance, clock offset. Exit status 6: an "
     "expected router did not answer.",
     "timsctl router list", router_list, kRows},

    {"link", "show", "[NAME]", 0, 1, kShowOptions, false,
     "Show links to other routers: state, round-trip time, loss, rates, queues, drops.",
     "timsctl link show robot1 -o wide", link_show, kRows},
    {"link", "up", "NAME", 1, 1, "", false, "Bring a link up again that was taken down.",
     "timsctl link up robot1", link_up},
    {"link", "down", "NAME", 1, 1, "yes", false,
     "Take a link down: its mailboxes are withdrawn, and it stays down until `link up`.",
     "timsctl link down robot1", link_down},
    {"link", "reset", "NAME", 1, 1, "", false, "End the session of a link and start a new one.",
     "timsctl link reset robot1", link_reset},

    {"fleet", "show", "", 0, 0, kShowOptions, false,
     "List the routers that announce themselves by DDS, with their addresses, and the state of "
     "DDS itself.",
     "timsctl fleet show", fleet_show, kRows},
    {"fleet", "server", "[ADDRESS:PORT]", 0, 1, "", false,
     "Run a Fast DDS discovery server until Ctrl-C: routers whose dds.server names it find each "
     "other without multicast. Default address: 0.0.0.0:11811.",
     "timsctl fleet server 10.9.1.1:11811", fleet_server},

    {"route", "show", "[GLOB]", 0, 1, "watch count once sort all-routers", false,
     "Show every registered address with its port or link and its owner. -a: at every router.",
     "timsctl route show 'Ladar(*/0)'", route_show, kRows},
    {"route", "add", "GLOB ROUTER", 2, 2, "", false,
     "Add a static route until the router ends: unregistered addresses that match GLOB go to this "
     "neighbour.",
     "timsctl route add 'Ladar(3/*)' robot3", route_add},
    {"route", "del", "GLOB [ROUTER]", 1, 2, "", false, "Remove a static route.",
     "timsctl route del 'Ladar(3/*)'", route_del},
    {"route", "get", "ADDR", 1, 1, "from type", false,
     "Ask the forwarding code where a message would go. Exit status 0: delivered, 1: not.",
     "timsctl route get Ladar/3/0 --from Pilot/3/0 --type get_data", route_get, kRows},
    {"route", "watch", "[GLOB]", 0, 1, "count once for", true,
     "Show registrations as they are added and removed.", "timsctl route watch 'Camera(*/*)'",
     route_watch},

    {"acl", "show", "", 0, 0, kShowOptions, false,
     "Show the rules of the router's policy in order, built-in ones in parentheses: the first that "
     "matches a message decides.",
     "timsctl acl show", acl_show, kRows},
    {"acl", "hits", "", 0, 0, kShowOptions, false,
     "Show what the rules have met: messages, and those that were denied, lowered, or left out of "
     "streams.",
     "timsctl acl hits --sort denied", acl_hits, kRows},
    {"acl", "test", "", 0, 0, "from to type priority", false,
     "Ask every router on the way of a message what its rules say. --from: identities of the "
     "sender, as `router clients -o wide` shows them; --type: a type, or look, change, login. Exit "
     "status 0: allowed, 1: denied.",
     "timsctl acl test --from user:guest --to 'Chassis(3/0)' --type move --priority 200", acl_test},
    {"acl", "log", "", 0, 0, "count", false,
     "Show the router's audit log: who was refused and denied what, who drove, who changed the "
     "router or its rules. -n N: the newest N of at most 1024.",
     "timsctl acl log -n 20", acl_log, kRows},

    {"mbx", "list", "[GLOB]", 0, 1, kShowOptions, false,
     "List mailboxes: owner, waiting, replaced and refused messages.",
     "timsctl mbx list Ladar --sort replaced", mbx_list, kRows},
    {"mbx", "show", "ADDR", 1, 1, kShowOptions, false, "Show the details of a mailbox.",
     "timsctl mbx show Ladar/3/0", mbx_show, kRows},

    {"component", "list", "[GLOB]", 0, 1, "watch count once sort wait all-routers", false,
     "List components and their state: all with a mailbox at this router or behind its links; if "
     "none of them matches GLOB, and with -a, those of all routers of the fleet. --wait: wait for "
     "at least one component.",
     "timsctl component list 'Ladar(*/*)'", component_list, kRows},
    {"component", "status", "ADDR...", 1, 64, "wait", false,
     "Show whether components are on. Exit status 1: not all are on. --wait: wait until they are.",
     "timsctl component status Chassis/1/0 Pilot/1/0", component_status, kRows},
    {"component", "show", "ADDR", 1, 1, "", false,
     "Show the details of a component: time since ON, parameters, subscribers, and violations of "
     "real-time behaviour (monitored in components with a real-time priority, in others if they "
     "are started with RACK_WATCH=1).",
     "timsctl component show Chassis/1/0", component_show},
    {"component", "describe", "ADDR", 1, 1, "", false,
     "Show what a component states about itself: its parameters with unit, range and default, the "
     "components that it uses, and its data. Its program prints the same with --describe.",
     "timsctl component describe Chassis/1/0", component_describe, kRows},
    {"component", "on", "ADDR...", 1, 64, "wait", false,
     "Turn components on, one after the other, and wait for each. --wait: try again if a component "
     "does not exist yet or refuses.",
     "timsctl component on Pilot/1/1 --wait", component_on},
    {"component", "off", "ADDR...", 1, 64, "no-wait wait", false,
     "Turn components off and wait until they are.", "timsctl component off Pilot/1/1",
     component_off},
    {"component", "param", "get|set|save ADDR [NAME] [VALUE]", 2, 4, "wait dry-run", false,
     "Show all parameters of a component or one of them, or set one; the answer states when the "
     "new "
     "value takes effect. save: write the parameters that were set since `timsctl up` started the "
     "component (or only NAME) into the robot file; comments and order are kept. Run save on the "
     "host of the robot.",
     "timsctl component param set Chassis/1/0 vxMax 500", component_param, kRows},
    {"component", "data", "ADDR", 1, 1, "body-max wait si newest", false,
     "Show the newest data of a component, field by field. --wait: wait until it has data. "
     "--newest: show the newest sample that passed the router, with its age, also when the "
     "component or its robot is not reachable; the router keeps those of newest.streams.",
     "timsctl component data Position/1/0", component_data, kLines},
    {"component", "pilot", "CHASSIS [PILOT|none]", 1, 2, "wait", false,
     "Show the active pilot of a chassis; with PILOT: set the only pilot that may drive it.",
     "timsctl component pilot Chassis/1/0 Pilot/1/1", component_pilot},

    {"log", "show", "", 0, 0, "component level since until count once directory", false,
     "Show log messages of components from the files of gdos-log on this host; needs no router. "
     "-n N: the newest N. Exit status 1: no message found.",
     "timsctl log show -c 'Chassis(*/*)' -l warning -S 10min", log_show},
    {"log", "follow", "[ADDR]", 0, 1, "component level count for directory", true,
     "Show log messages of components as they arrive: time, sender, level, text. They come from "
     "gdos-log if it runs, also on another robot (ADDR); else directly from the components, and "
     "then only one program can receive them. -n N: first show the newest N messages from the "
     "files of gdos-log on this host.",
     "timsctl log follow -n 20 -l warning", log_follow},

    {"ping", "", "ADDR|router", 1, 1, "count once for interval size priority hops", false,
     "Measure round-trip times to a component (with GET_STATUS) or a router (`router` or an "
     "address "
     "such as Tims/1/1; with the admin ping). Sends 4 requests unless -n or --for is given. "
     "--hops: measure every router on the path first.",
     "timsctl ping Ladar/3/0 -n 10 -i 100ms", ping},

    {"explain", "", "SRC DST", 2, 2, "type", false,
     "Ask every router on the path what it would do with a message; the last line states the cause "
     "and the remedy. Exit status 0: the message arrives, 1: it does not.",
     "timsctl explain Pilot/1/0 Ladar/2/0", explain},
    {"trace", "", "ADDR", 1, 1, "type priority", false,
     "Send GET_STATUS with the TRACE flag: every router on the path reports when the message "
     "passed "
     "and how long it waited there.",
     "timsctl trace Ladar/2/0", trace},
    {"clock", "", "", 0, 0, kShowOptions, false,
     "Show the clock offset of every router to the first one, from the keep-alives of the links.",
     "timsctl clock", clock, kRows},

    {"msg", "pub", "ADDR [TYPE] [FIELD=VALUE...] [-]", 1, 256,
     "hex file raw rate count once for priority yes no-wait fields si", false,
     "Send a message: by name with fields (omitted fields keep the default of the struct), as "
     "bytes, "
     "or from the output of `msg echo --raw` or --json. Numbers are in the units of `msg show` or "
     "have a unit: vx=0.2m/s. A command (TYPE > 0) that is sent once waits for its answer. Asks "
     "for "
     "confirmation if ADDR moves something.",
     "timsctl msg pub Chassis/0/0 move vx=200 omega=0.1", msg_pub},
    {"msg", "echo", "[ADDR...]", 0, 64,
     "listen count once for period body-max priority raw fields si filter", true,
     "Print the data of a component as it arrives, one message per line. Subscribes with "
     "GET_CONT_DATA and unsubscribes at the end; with --listen, registers an address and prints "
     "the "
     "messages that arrive there. The output of --raw and --json is valid input of `msg pub -f`.",
     "timsctl msg echo Chassis/0/0 --si --filter 'vx>0.1'", msg_echo, kLines},
    {"msg", "types", "[CLASS|every]", 0, 1, "", false,
     "List the messages of a class or of all classes: numbers, names, bodies. `every`: those that "
     "every component understands. Needs no router.",
     "timsctl msg types Chassis", msg_types, kRows},
    {"msg", "show", "CLASS NAME", 2, 2, "", false,
     "Show the fields of a message, with their units. Needs no router.",
     "timsctl msg show Chassis move", msg_show, kRows},
    {"msg", "hz", "ADDR...", 1, 64, "count once for interval period body-max", true,
     "Measure message rates, side by side. -n N: stop after N reports.",
     "timsctl msg hz Ladar/3/0 Odometry/3/0 --for 10s", msg_hz, kRows},
    {"msg", "bw", "ADDR...", 1, 64, "count once for interval period body-max", true,
     "Measure data rates, side by side. -n N: stop after N reports.",
     "timsctl msg bw Camera/3/0 --once", msg_bw, kRows},

    {"top", "", "", 0, 0, "count once for interval sort", true,
     "Show clients and their rates, live. Keys: h for help, q quits, left and right select the "
     "column.",
     "timsctl top --sort in/s", top, kRows},
    {"stats", "", "", 0, 0, "watch count once sort by", false,
     "Show message counts by port, class and outcome, and those of local mailboxes.",
     "timsctl stats --by reason", stats, kRows},

    {"config", "show", "", 0, 0, "watch count once sort origin", false,
     "Show the configuration that the router uses.", "timsctl config show --origin", config_show,
     kRows},
    {"config", "check", "FILE", 1, 1, "", false,
     "Check a configuration file as the router would, or that of a robot. Exit status 1: it has "
     "errors.",
     "timsctl config check /etc/tims/router.toml", config_check},
    {"config", "migrate", "FILE...", 1, 64, "dry-run", false,
     "Rewrite keys that had another name in the former release, in files of routers, robots and "
     "worlds on this host, and show what changes; all else stays as it is, byte for byte.",
     "timsctl config migrate /etc/tims/robots/scout.toml --dry-run", config_migrate},
    {"config", "diff", "EDIT...", 1, 64, "", false,
     "Show what edits of configuration files would change, as text and as sentences, and whether "
     "their hosts accept them. EDIT: [ROUTER@]FILE=SOURCE takes the text of a file of this host; "
     "[ROUTER@]FILE:PATH=VALUE sets one value, and without VALUE removes it. FILE: router.toml or "
     "robots/NAME.toml, on the host of ROUTER. Needs tims-agent there. Exit status 1: refused.",
     "timsctl config diff 'robots/scout.toml:component[2].parameters.maxRange=10000'", config_diff},
    {"config", "apply", "EDIT...", 1, 64, "why window yes", false,
     "Change configuration files of one or several hosts: check all, write, restart only what "
     "changed, then keep the change (-y: at once, over a new connection) or go back. All hosts go "
     "back by themselves unless the change is confirmed in time. EDIT as for `config diff`. Ctrl-C "
     "takes the change back. Exit status 1: refused, or not kept.",
     "timsctl config apply arm@router.toml:log.level=debug --why 'find the fault'", config_apply},
    {"config", "confirm", "[CHANGE]", 0, 1, "", false,
     "Keep the change that is under way, on all of its hosts.", "timsctl config confirm",
     config_confirm},
    {"config", "undo", "[CHANGE]", 0, 1, "generation why window yes", false,
     "Take back the change that is under way, on all of its hosts; or with --generation N make the "
     "files of an older generation a new change.",
     "timsctl config undo --generation 7 -y", config_undo},
    {"config", "history", "", 0, 0, "count sort", false,
     "Show the last generations of the configuration files of a host: who changed them, when, why, "
     "and what became of it.",
     "timsctl config history -r arm", config_history, kRows},
    {"config", "budget", "", 0, 0, "sort", false,
     "Show what the links between the routers carry: at most, from the periods and sizes of the "
     "data "
     "that components use of other hosts, and now. Yellow from 70 % of a link's rate, red from "
     "100 %. Exit status 1: red.",
     "timsctl config budget", config_budget, kRows},

    {"key", "init", "", 0, 0, "fleet keys role system id name", false,
     "Make the authority of a fleet and the keys of this host, the base (a top router unless "
     "--role "
     "says otherwise). Called again: another certificate for this host, if role, system, id or "
     "name are others. Needs no router.",
     "timsctl key init --fleet harbour --keys /etc/tims/keys", key_init},
    {"key", "list", "", 0, 0, "keys sort", false,
     "List all certificates that this base has issued: valid, replaced by a newer one, of an old "
     "root, revoked. Needs no router.",
     "timsctl key list", key_list, kRows},
    {"key", "show", "", 0, 0, "keys", false,
     "Show whose certificate lies in the folder, until when it is valid, the fingerprints of the "
     "roots that are believed, the list of revoked certificates. Exit status 1: revoked or "
     "expired. "
     "Needs no router.",
     "timsctl key show", key_show},
    {"key", "ca", "[FILE]", 0, 1, "keys", false,
     "Write the roots that are believed (PEM): a browser that has imported them accepts the "
     "console "
     "of each host of the fleet. Needs no router.",
     "timsctl key ca harbour.pem", key_ca},
    {"key", "request", "[FILE]", 0, 1, "keys", false,
     "Without a network, step 1, on the robot: make a key and write a request for a certificate.",
     "timsctl key request /media/stick/robot3.request", key_request},
    {"key", "sign", "REQUEST [ANSWER]", 1, 2, "keys role system id name rights", false,
     "Without a network, step 2, on the base: sign a request. ANSWER has certificate, roots and "
     "list; nothing in it is secret.",
     "timsctl key sign robot3.request robot3.answer --role system --system 3", key_sign},
    {"key", "import", "ANSWER", 1, 1, "keys force", false,
     "Without a network, step 3, on the robot: take certificate, roots and list over. An answer of "
     "another authority than that of the keys in the folder is refused (unless --force).",
     "timsctl key import /media/stick/robot3.answer", key_import},
    {"key", "renew", "", 0, 0, "keys", false,
     "Get a new certificate for a new key; also after the present one has expired. On a robot: "
     "from "
     "`key serve` of the base.",
     "timsctl key renew", key_renew},
    {"key", "revoke", "NAME...", 1, 64, "keys", false,
     "Revoke all certificates of a member, by its name, by ROLE/SYSTEM/ID, or by the beginning of "
     "a "
     "serial number. Run it on the base: its router passes the new list on to the fleet.",
     "timsctl key revoke robot3", key_revoke},
    {"key", "rotate", "", 0, 0, "keys finish force", false,
     "Replace the root of the fleet. Members believe both roots until --finish, which is refused "
     "while somebody has a certificate of the old one (unless --force).",
     "timsctl key rotate", key_rotate},
    {"key", "serve", "", 0, 0, "keys until-idle detach for", true,
     "Serve joining and renewing on TCP port 2011. `token new` starts it if needed, until no token "
     "is open any more.",
     "timsctl key serve --keys /etc/tims/keys", key_serve},

    {"tunnel", "", "LISTEN ROUTER", 2, 2, "keys", true,
     "Lead programs that speak in the clear, such as those of the original RACK, through TLS to "
     "the "
     "TCP port of a router, with the keys of this host: whoever can reach LISTEN has their rights. "
     "ROUTER: HOST:PORT, as HOST stands in the router's certificate (at loopback: any), or "
     "HOST:PORT/NAME with the router's name, where the address is another one (NAT, port "
     "forwarding). "
     "LISTEN \"-\": one connection, the socket at stdin; programs whose router is tls:HOST:PORT "
     "start it so.",
     "timsctl tunnel 127.0.0.1:2000 base:2000", tunnel},
    {"web", "", "", 0, 0, "rights bearer address", false,
     "Log in: print the link that opens the console in a browser, once and within 60 s. With "
     "--rights look, drive or configure at most that; else all that you may. Ask over the Unix "
     "socket of the router's host, or over tls:HOST:PORT as a user of the fleet.",
     "timsctl web --rights drive", web},
    {"token", "new", "", 0, 0, "keys role system id name rights address", false,
     "Print the text with which a robot or user joins the fleet: once, within an hour. It has a "
     "secret: show it to nobody else.",
     "timsctl token new --role system --system 3", token_new},
    {"token", "list", "", 0, 0, "keys sort", false, "List tokens: open, used, ended.",
     "timsctl token list", token_list, kRows},
    {"token", "revoke", "ID...", 1, 64, "keys", false, "Revoke tokens that were not used yet.",
     "timsctl token revoke 5f0c12ab", token_revoke},

    {"join", "", "TEXT", 1, 1, "keys", false,
     "Join the fleet of a text of `token new`: make a key here, prove the secret to the base, get "
     "the certificate. May be repeated after an interruption. Needs no router.",
     "timsctl join tims-join:10.9.1.1:2011/ABEiM0RV...", join},

    {"device", "list", "", 0, 0, "sort", false,
     "List the devices of this host: serial ports, CAN interfaces, cameras, joysticks, I/O lines; "
     "with the driver program, the address for its --device, and obstacles: permissions, a missing "
     "kernel module, or the process that uses the device. Needs no router.",
     "timsctl device list", device_list, kRows},
    {"device", "watch", "", 0, 0, "count once for", true,
     "Show devices as they are plugged in and unplugged. Needs no router.", "timsctl device watch",
     device_watch},
    {"device", "record", "DEVICE FILE", 2, 2, "count once for", true,
     "Record the input from a device that no program uses, like --record of a driver; play it with "
     "--device=play:FILE. If the device is unplugged, wait until it is back.",
     "timsctl device record 'serial:/dev/ttyUSB0?baud=9600' gps.cap --for 1min", device_record},
    {"device", "play", "FILE [DEVICE]", 1, 2, "for", false,
     "Show the content of a recording (of timsctl or a driver, candump, pcap, raw bytes): records, "
     "bytes, gaps, events. With DEVICE (pty:PATH, tcp:127.0.0.1:PORT, udp:HOST:PORT, "
     "can:INTERFACE): play it there in place of the device. FILE?speed=max plays without pauses, "
     "?loop=1 repeatedly, ?port=N one port of a packet capture.",
     "timsctl device play gps.cap pty:/tmp/gps", device_play},

    {"camera", "save", "CAMERA FILE", 2, 2, "objects", false,
     "Save the newest picture of a camera as .png, or as .jpg if its mode is jpeg.",
     "timsctl camera save Camera/0/0 markers.png --objects ObjRecog/0/0", camera_save},

    {"world", "show", "", 0, 0, "watch count once sort world body-max", false,
     "Show the true state of a simulated world: poses of robots and people, contacts, unplugged "
     "sensors.",
     "timsctl world -w", world_show, kRows},
    {"world", "place", "ROBOT X Y [RHO]", 3, 4, "world si", false,
     "Move a robot to a pose: X north and Y east in mm, RHO in rad clockwise from north; or with a "
     "unit, such as 1.5m.",
     "timsctl world place scout 1500 -2000 1.57", world_place},
    {"world", "put", "X Y RADIUS", 3, 3, "world si", false,
     "Place a post, 1 m high, into the world and print its id.", "timsctl world put 4m 0 200",
     world_put},
    {"world", "remove", "ID", 1, 1, "world", false, "Remove a post.", "timsctl world remove 3",
     world_remove},
    {"world", "people", "on|off", 1, 1, "world", false,
     "Let all people walk (on) or stand still (off).", "timsctl world people off", world_people},
    {"world", "unplug", "ROBOT SENSOR", 2, 2, "world", false,
     "Unplug a device from its line; `base` is the drive of the robot.",
     "timsctl world unplug scout laser", world_unplug},
    {"world", "plug", "ROBOT SENSOR", 2, 2, "world", false, "Plug a device in again.",
     "timsctl world plug scout laser", world_plug},

    {"nav", "where", "[ROBOT]", 0, 1, "robot watch count once", false,
     "Show the pose of a robot: x (north), y (east), heading, uncertainty and source; if it is "
     "unknown, what is missing and what to do. Exit status 1: unknown.",
     "timsctl nav where", nav_where},
    {"nav", "goto", "X Y [HEADING]", 2, 3, "robot gps no-wait anyway for patience", false,
     "Send a robot to a position on its map, in m and degrees (clockwise from x), and show its "
     "progress until it arrives. Turns on the components that are needed and turns off the pilot "
     "that was driving. Without HEADING any final heading is accepted. A robot that is not "
     "sure where it is is not sent, except with --anyway. Ctrl-C, the end of --for "
     "and "
     "any failure stop the robot. Exit status 0: arrived, 1: not, with the reason.",
     "timsctl nav goto 3.5 6 180", nav_goto},
    {"nav", "path", "[ROBOT]", 0, 1, "robot watch count once sort plot", false,
     "Show the path that a robot follows: lines and arcs, with lengths, radii and speeds.",
     "timsctl nav path --plot path.svg", nav_path, kRows},
    {"nav", "map", "[show|load] [FILE]", 0, 2, "robot plot", false,
     "Show the maps that the components of a robot use. load: set another map, a floor plan (.dxf) "
     "or a ROS map (.yaml, a file on the robot's host), for all components that use one; it takes "
     "effect at once or at their next ON. Exit status 1: a component refused it.",
     "timsctl nav map load floor.dxf", nav_map, kRows},
    {"nav", "plot", "PICTURE FILE...", 2, 64, "", false,
     "Draw recorded drives as .svg or .png: maps (.yaml, .dxf), files of DatalogRec, CARMEN logs, "
     "output of `mcl-eval --poses` and `msg echo -o csv`, any file with named columns; also "
     "errors, "
     "if one trajectory is the ground truth. NAME=FILE names a trajectory. Needs no router.",
     "timsctl nav plot drive.png map.yaml position_0.dat truth=truth.csv", nav_plot},

    {"doctor", "", "", 0, 0, "format", false,
     "Check for common problems. Exit status 1: a problem was found; 3: no router. --format nagios "
     "exits with 0 to 3, as monitoring expects.",
     "timsctl doctor", doctor},
    {"errors", "", "[CODE]", 0, 1, "", false,
     "Explain an error code, reason or finding, and the remedy.", "timsctl errors no_route", errors,
     kRows},
    {"completion", "", "bash|zsh|fish", 1, 1, "", false,
     "Print a shell script that completes verbs and registered addresses.",
     "source <(timsctl completion bash)", completion},
    {"__complete", "", "COMMAND...", 0, 1000, "", false, "", "", complete},
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

// The one name that begins with `prefix`.
std::string_view expand(std::string_view prefix, std::span<const std::string_view> names,
                        const std::string& what) {
  std::vector<std::string_view> fits;
  for (const std::string_view name : names) {
    if (name == prefix) return name;
    if (name.starts_with(prefix)) fits.push_back(name);
  }
  if (fits.size() == 1) return fits.front();
  if (fits.size() > 1)
    throw usage_error(fmt::format("\"{}\" is ambiguous: {}", prefix, fmt::join(fits, ", ")),
                      "write more letters");
  throw usage_error(fmt::format("no {} \"{}\"", what, prefix), nearest_hint(prefix, names));
}

// "Ladar(3/0)" and "0x03140000" are never verbs.
bool looks_like_verb(std::string_view argument) {
  return std::ranges::all_of(argument, [](char c) { return c >= 'a' && c <= 'z'; });
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

Resolved resolve(std::span<const std::string> arguments) {
  if (arguments.empty()) return {find("status", ""), "status", 0};
  if (arguments[0] == "__complete") return {find(arguments[0], ""), arguments[0], 1};
  const std::string_view noun = expand(arguments[0], nouns(), "command");
  if (const Verb* only = find(noun, "")) return {only, noun, 1};
  const Verb* usual = find(noun, "show");
  if (usual == nullptr || usual->arguments_min > 0) usual = find(noun, "list");
  if (arguments.size() == 1) return {usual, noun, 1};
  if (!looks_like_verb(arguments[1]) && usual != nullptr) return {usual, noun, 1};
  const auto names = verbs_of(noun);
  return {find(noun, expand(arguments[1], names, std::string(noun) + " verb")), noun, 2};
}

// --- the command line

namespace {

std::string overview() {
  std::string text =
      "timsctl NOUN [VERB] [ARGUMENTS] [OPTIONS]: query and control a router and its components.\n"
      "Nouns and verbs may be abbreviated to a unique prefix (`timsctl mb li`). Without "
      "arguments,\n"
      "`timsctl status` is run.\n\n";
  for (const Verb& verb : verbs())
    if (!verb.example.empty()) text += verb_line(verb.name(), verb);
  text += "\nGeneral options:\n" + option_lines(kGeneralOptions);
  text += "  -h, --help                    show the options and an example of a noun or verb\n";
  text +=
      "\nADDR is Ladar(3/0), Ladar/3/0 (needs no quotes), Ladar/3/0:2 or 0x03140000. A GLOB may "
      "have\n"
      "* in any position: 'Ladar(*/0)'; Ladar alone is the whole class.\n"
      "Environment: TIMS_HOST (default of -H), TIMS_ROUTER (router of the programs on this host),\n"
      "TIMS_PAGER or PAGER (shows long tables; cat: none), NO_COLOR, RACK_MESSAGES (descriptions "
      "of\n"
      "messages of your own classes).\n";
  return text.append(kExitHelp);
}

std::string noun_help(std::string_view noun) {
  std::string text = fmt::format("timsctl {} VERB\n", noun);
  for (const Verb& verb : verbs())
    if (verb.noun == noun) text += verb_line(verb.name(), verb);
  return text + fmt::format("More: timsctl {} VERB --help\n", noun);
}

std::string help_for(std::span<const std::string> arguments) {
  if (arguments.empty()) return overview();
  const Resolved found = resolve(arguments);
  const bool only_a_noun = arguments.size() == 1 && find(found.noun, "") == nullptr;
  if (found.verb == nullptr || only_a_noun) return noun_help(found.noun);
  return verb_help("timsctl " + found.verb->name(), *found.verb);
}

Exit become_own(Context& context) {
  become_verb(context.verb.program, context.verb.short_name(), context.options,
              context.options.arguments);
}

RunVerb run_of(const Verb& verb) { return verb.run == nullptr ? become_own : verb.run; }

}  // namespace

const Program& timsctl_program() {
  static const Program program{"timsctl", &Verb::name, resolve, run_of, help_for};
  return program;
}

void become_verb(std::string_view program, const std::string& verb, const Options& options,
                 std::span<const std::string> arguments) {
  tims::os::Command command{std::string(program), verb};
  command.insert(command.end(), options.given.begin(), options.given.end());
  command.emplace_back("--");
  command.insert(command.end(), arguments.begin(), arguments.end());
  become({.command = std::move(command)});
}

}  // namespace timsctl
