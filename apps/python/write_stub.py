"""write_stub.py FOLDER: writes FOLDER/fuse_flow/__init__.pyi, what type checkers and editors read, from the module's own signatures."""

import inspect
import re
import sys

sys.path.insert(0, sys.argv[1])
import fuse_flow._fuse_flow as module  # noqa: E402

HEAD = '''"""%s"""

import collections.abc
import datetime
import typing
from os import PathLike
from typing import Any, ClassVar, Iterator, Optional, Sequence, Union

import numpy
import numpy.typing
from numpy.typing import ArrayLike
'''

# What a property that is set from more than it returns takes, and returns where pybind11 cannot know.
TYPES = {
    "DepthView.depth": ("Optional[numpy.ndarray]", "Optional[ArrayLike]"),
    "DepthView.color": ("Optional[numpy.ndarray]", "Optional[ArrayLike]"),
    "DepthView.confidence": ("Optional[numpy.ndarray]", "Optional[ArrayLike]"),
    "RigFrame.cameras": ("list[Camera]", "Sequence[Camera]"),
    "RigFrame.views": ("list[Optional[DepthView]]", "Sequence[Optional[DepthView]]"),
    "FuseFlowParameters.crop_box": (
        "Optional[tuple[ArrayLike, ArrayLike]]", "Optional[tuple[ArrayLike, ArrayLike]]"),
}
ARGUMENTS = {
    "DepthView.__init__": "depth: Optional[ArrayLike] = None, color: Optional[ArrayLike] = None, "
                          "confidence: Optional[ArrayLike] = None",
    "RigFrame.__init__": "cameras: Sequence[Camera], views: Sequence[Optional[DepthView]], stamp: int = 0",
}
PATHS = "Union[str, PathLike[str], Sequence[Union[str, PathLike[str]]]]"


def annotation(text):
    """A type as pybind11 writes it, in the words of typing."""
    text = text.replace("fuse_flow._fuse_flow.", "")
    text = re.sub(r"numpy\.ndarray\[[^\]]*\](\])?", "numpy.ndarray", text)
    text = re.sub(r"\bList\[", "list[", text)
    text = re.sub(r"\bTuple\[", "tuple[", text)
    text = re.sub(r"\bDict\[", "dict[", text)
    text = re.sub(r"list\[float\[3\]\]|Annotated\[list\[float\], FixedSize\(3\)\]", "ArrayLike", text)
    return text


def arguments(text):
    text = annotation(text)
    text = re.sub(r"<(\w+)\.(\w+): -?\d+>", r"\1.\2", text)  # the default of an enumeration
    text = re.sub(r"= <[^>]*>|= Distortion\(\)|= [\w.]+ object at \w+", "= ...", text)
    text = re.sub(r"\b(path|source): (object|handle)", r"\1: " + PATHS, text)
    text = re.sub(r"\bcloud: (object|handle)", "cloud: Union[Cloud, StreamedCloud, ArrayLike]", text)
    text = re.sub(r": (object|handle) = None", ": Optional[ArrayLike] = None", text)
    text = re.sub(r": (object|handle)\b", ": ArrayLike", text)
    text = re.sub(r": (\w+) = None", r": Optional[\1] = None", text)
    text = re.sub(r"\*\*kwargs", "**values: Any", text)
    return text


def indented(text, depth):
    space = "    " * depth
    return "\n".join(space + line if line else "" for line in text.split("\n"))


def docstring(text, depth):
    text = text.strip()
    return indented('"""' + text + ('\n' if "\n" in text else "") + '"""', depth) + "\n" if text else ""


def signatures(function):
    """Pairs of (arguments, result), and the sentence."""
    text = function.__doc__ or ""
    name = function.__name__
    found = re.findall(rf"^(?:\d+\. )?{re.escape(name)}\((.*)\) -> (.*)$", text, re.M)
    sentence = re.sub(rf"^(?:\d+\. )?{re.escape(name)}\(.*\) -> .*$|^Overloaded function\.$", "", text, flags=re.M)
    return found, re.sub(r"\n{3,}", "\n\n", sentence).strip()


def write_function(function, depth, owner=None, static=False):
    found, sentence = signatures(function)
    name = function.__name__
    out = ""
    for args, result in found:
        args = arguments(args)
        if owner:
            args = ARGUMENTS.get(f"{owner}.{name}", None) if f"{owner}.{name}" in ARGUMENTS else re.sub(r"^self: [\w.\[\]]+(, )?", "", args)
            if not static:
                args = "self" + (", " + args if args else "")
        if len(found) > 1:
            out += indented("@overload", depth) + "\n"
        if static:
            out += indented("@staticmethod", depth) + "\n"
        result = annotation(result)
        if result in ("object", "handle"):
            result = "Any"
        out += indented(f"def {name}({args}) -> {result}:", depth) + "\n"
        out += (docstring(sentence, depth + 1) or "") + indented("...", depth + 1) + "\n"
    return out


def write_property(owner, name, value):
    getter = re.search(r"-> (.*)$", (value.fget.__doc__ or "").split("\n")[0])
    result = annotation(getter.group(1)) if getter else "Any"
    takes = result
    if f"{owner}.{name}" in TYPES:
        result, takes = TYPES[f"{owner}.{name}"]
    elif value.fset is not None:
        setter = re.search(r"arg[01]: ([^,)]*(?:\[[^)]*\])?)\) -> None", (value.fset.__doc__ or "").split("\n")[0])
        takes = annotation(setter.group(1)) if setter else result
        takes = "ArrayLike" if takes in ("object", "handle") else takes
    if result in ("object", "handle"):
        result = "Any"
    sentence = value.__doc__ or ""
    out = f"    @property\n    def {name}(self) -> {result}:\n" + (docstring(sentence, 2) or "") + "        ...\n"
    if value.fset is not None:
        out += f"    @{name}.setter\n    def {name}(self, value: {takes}) -> None: ...\n"
    return out


def write_class(name, cls):
    out = f"class {name}:\n" + docstring(cls.__doc__.split("\n\nMembers:")[0] if cls.__doc__ else "", 1)
    if hasattr(cls, "__members__"):  # an enumeration
        sentences = dict(re.findall(r"^  (\w+) : (.*(?:\n(?!\s*\w+ :).*)*)", cls.__doc__ or "", re.M))
        for member in cls.__members__:
            out += f"    {member}: ClassVar[{name}]\n" + docstring(sentences.get(member, ""), 1)
        out += "    def __init__(self, value: int) -> None: ...\n    @property\n    def name(self) -> str: ...\n"
        out += "    @property\n    def value(self) -> int: ...\n    def __int__(self) -> int: ...\n"
        out += f"    __members__: ClassVar[dict[str, {name}]]\n"
        return out
    body = ""
    for member, value in vars(cls).items():
        if member in RETURNS_SELF and (member != "__iter__" or hasattr(cls, "__next__")):
            body += f"    def {member}(self) -> {name}: ...\n"
        elif member == "__exit__":
            body += "    def __exit__(self, *exception: Any) -> None: ...\n"
        elif isinstance(value, property):
            body += write_property(name, member, value)
        elif isinstance(value, staticmethod):
            body += write_function(value.__func__, 1, name, True)
        elif callable(value) and member not in ("__new__",) and (not member.startswith("_") or member in DUNDERS):
            body += write_function(value, 1, name)
    return out + (body or "    ...\n")


# Of these the module knows no type, as they take and return any object.
RETURNS_SELF = ("__enter__", "__iter__")
DUNDERS = ("__init__", "__len__", "__iter__", "__next__", "__repr__", "__copy__", "__deepcopy__", "__iadd__")


def main():
    out = ""
    for name, value in sorted(vars(module).items()):
        if name.startswith("_"):
            continue
        if inspect.isclass(value):
            out += "\n" + write_class(name, value)
        elif callable(value):
            out += "\n" + write_function(value, 0)
    head = HEAD % (module.__doc__ or "")
    if "@overload" in out:
        head = head.replace("Union", "Union, overload")
    with open(sys.argv[1] + "/fuse_flow/__init__.pyi", "w", encoding="utf-8") as file:
        file.write(head + out)


if __name__ == "__main__":
    main()
