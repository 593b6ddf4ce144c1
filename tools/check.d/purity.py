"""Pure libraries call nothing of the system and keep no state of their own: those of the folders
with a ★ in layers.md, and NAME_core, the part of a folder of programs that only computes.

Proved on the object files: every undefined symbol must be in the list below or in another pure
library, and no variable may lie in writable memory.
"""

import os
import re
import subprocess

from layers import Layers
from tree import Finding

# What values, containers and exceptions of the standard library need. All of it computes.
ALLOWED = [re.compile(p) for p in (
    r"operator (new|delete)(\[\])?\(.*",
    r"mem(cpy|move|set|cmp|chr)|strlen|strcmp|bcmp|abort",
    r"std::nothrow|__stack_chk_fail|__cxa_.*|__gxx_personality_v0|__dso_handle|_Unwind_.*",
    r"_GLOBAL_OFFSET_TABLE_|__assert_fail|__errno_location",
    r"(vtable|typeinfo|typeinfo name|VTT) for (std|__cxxabiv1)::.*",
    r"std::__throw_.*|std::(__cxx11::)?basic_string.*|std::from_chars.*|std::to_chars.*",
    r"std::(logic|runtime)_error::.*|std::.*(exception|bad_\w+|out_of_range|length_error)::.*",
    r"std::(terminate|__glibcxx_assert_fail|get_unexpected).*",
    r"std::(_Hash_bytes|_Fnv_hash_bytes)\(.*|std::__detail::_Prime_rehash_policy::.*",
    r"std::_Rb_tree_\w+\(.*|std::_Sp_\w+.*|std::__detail::_List_node_base::.*",
    r"(floor|ceil|round|trunc|lround|llround|sqrt|pow|exp|exp2|log|log2|log10|ilogb|fmod|remainder|hypot)f?|__popcountdi2",
    r"fmt::v9::vformat.*",
    r"inet_pton",  # libtims/base/ip_network.cpp: numeric addresses from text, no system call
    r"GeographicLib::.*|(vtable|typeinfo) for GeographicLib::.*",  # projections: constants only
    r"rack::vision::(read_marker_map|picture_of)\(.*",  # the pure part of components/vision
    r"cv::.*|(vtable|typeinfo) for cv::.*",  # OpenCV on pictures in memory
    r"(LZ4|ZSTD)_\w+",  # router/compression: on blocks in memory, with contexts in memory of the caller
    r"__libc_single_threaded",  # its pointers, which are std::shared_ptr: how they count
    r"(m|c|re)alloc|free",  # components/mapping: Eigen takes its memory by them
    r"toml::v3::.*|(vtable|typeinfo) for toml::v3::.*|__cxa_pure_virtual",  # libtims/base/toml.cpp
    # components/geometry/dxf.cpp: dxflib, which reads from a stream over a text in memory
    r"DL_\w+::.*|(vtable|typeinfo) for DL_\w+|VTT for std::.*",
    r"std::(__cxx11::)?basic_(istringstream|stringbuf|streambuf|istream|ios)<char.*|std::(ios_base|locale)::.*",
    # components/localisation/ros_yaml.cpp: yaml-cpp, whose errors are formatted in its headers
    r"(non-virtual thunk to )?YAML::.*|(vtable|typeinfo) for YAML::.*",
    r"std::basic_(io|o)stream<char.*|std::basic_ostream<char, .*>& std::(__ostream_insert|basic_ostream)<.*",
    r"(sin|cos|tan|asin|acos|atan|atan2|sincos|sinh|cosh|tanh|atanh)f?",
)]
# Sanitizer builds call their own runtime.
INSTRUMENTED = re.compile(r"__(asan|ubsan|tsan|sanitizer)_.*")
# What people call classes is the same in all of a program (name_class(), libtims/include/tims/address.h).
NAMES = re.compile(r"tims::\(anonymous namespace\)::own")
# Written by the loader only.
RELOCATED = re.compile(r"DW\.ref\..*")
# Of <iostream>, which dxflib's headers include (components/geometry/dxf.cpp).
STREAMS = re.compile(r"std::__ioinit")
CORE = re.compile(r"^tims_library\((\w+_core)\s", re.MULTILINE)
# Libraries of a folder beside the one of its name.
BESIDE = {
    "components/devices/camera": ("devices_pictures",),
    "components/geometry": ("components_coordinates", "components_geometry_dxf"),
    "components/pictures": ("camera_calibration", "grey_pictures", "raster_canvas"),
    "libtims/base": ("tims_toml",),
}


# Folders of components whose libraries are named without the first part.
SHORT = "components/devices/", "components/world/"


def library_name(folder):
    name = folder.removeprefix("components/") if folder.startswith(SHORT) else folder
    return name.replace("libtims/", "tims_").replace("/", "_")


def _lines(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


def undefined_symbols(archive):
    return {line.split()[-1] for line in _lines("nm", "--undefined-only", str(archive))
            if line.startswith(" ") and len(line.split()) == 2}


def defined_symbols(archive):
    return {line.split()[-1] for line in _lines("nm", "--defined-only", str(archive))
            if len(line.split()) == 3}


def variables(archive):
    """Names of objects in writable sections; constants with relocations are not among them."""
    for line in _lines("objdump", "-t", str(archive)):
        fields = line.split()
        if len(fields) < 5 or "O" not in line[17:24]:
            continue
        section = line[25:].split()[0]
        if re.match(r"\.(t?bss|t?data)(\.|$)", section) and not section.startswith(".data.rel.ro"):
            yield fields[-1]


def demangle(symbols):
    names = sorted(symbols)
    output = subprocess.run(["c++filt"], input="\n".join(names), capture_output=True, text=True,
                            check=True).stdout.splitlines()
    return dict(zip(names, output))


def libraries(tree):
    """(folder, name) of each."""
    for folder in sorted(Layers(tree).pure):
        if any(f.startswith(folder + "/") and f.endswith(".cpp") for f in tree.files):
            for name in (library_name(folder), *BESIDE.get(folder, ())):
                yield folder, name
    for path in tree.files:
        if os.path.basename(path) == "CMakeLists.txt":
            for name in CORE.findall(tree.text(path)):
                yield os.path.dirname(path), name


def check(tree):
    archives = {}
    for folder, name in libraries(tree):
        found = sorted(tree.build.rglob(f"lib{name}.a"))
        if found:
            archives[found[0]] = folder
        else:
            yield Finding(folder, 0, f"lib{name}.a is not in {tree.build}: tools/dev build release all")
    inside = set().union(*(defined_symbols(a) for a in archives))
    for archive, folder in archives.items():
        for symbol, name in demangle(undefined_symbols(archive) - inside).items():
            if not any(p.fullmatch(name) for p in (*ALLOWED, INSTRUMENTED)):
                yield Finding(folder, 0, f"is pure but calls {name}: hand time, bytes and results "
                                         "in and out as arguments")
        for name in demangle(set(variables(archive))).values():
            if not INSTRUMENTED.fullmatch(name) and not RELOCATED.fullmatch(name) \
                    and not NAMES.fullmatch(name) and not STREAMS.fullmatch(name):
                yield Finding(folder, 0, f"is pure but keeps the variable {name}: state belongs to "
                                         "an object that a test can make twice")
