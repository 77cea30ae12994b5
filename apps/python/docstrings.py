"""docstrings.py OUTPUT HEADER…: the sentences of the headers, for the module's docstrings, as a table in C++.

A name is "Struct::member", "Struct" or "Enum::Enumerator". Sentences are in C++'s words; what Python calls otherwise is replaced.
"""

import re
import sys

WORDS = [
    (r"pcl::BadArgumentException", "ValueError"),
    (r"pcl::PCLException", "RuntimeError"),
    (r"std::bad_alloc", "MemoryError"),
    (r"std::invalid_argument", "ValueError"),
    (r"std::runtime_error", "RuntimeError"),
    (r"Throws (\w+) ", r"Raises \1 "),
    (r"\b(Eigen::Isometry3d|Eigen::AlignedBox3f)\b", ""),
    (r"(?<=\w)::(?=\w)", "."),
]


def snake(name):
    return re.sub(r"(?<=[a-z0-9])([A-Z])", lambda match: "_" + match.group(1).lower(), name)


def sentence(comment):
    """A doxygen comment without its marks: one line, or a paragraph a line."""
    comment = re.sub(r"^\s*\*?", "", comment, flags=re.M)
    comment = re.sub(r"\\code.*?\\endcode", "", comment, flags=re.S)
    comment = re.sub(r"\\copydetails \S+|\\copybrief \S+|\\brief|\\file", "", comment)
    comment = re.sub(r"\\throws", "\nRaises", comment)
    comment = re.sub(r"\\returns?", "\nReturns", comment)
    comment = re.sub(r"\\param\s+(\S+)", r"\n\1:", comment)
    comment = re.sub(r"\\[cp] ", "", comment)
    for pattern, word in WORDS:
        comment = re.sub(pattern, word, comment)
    comment = re.sub(r"\b[a-z]+[A-Za-z]*(?=\(\))", lambda match: snake(match.group(0)), comment)
    paragraphs = [" ".join(part.split()) for part in re.split(r"\n\s*\n|\n(?=Raises|Returns|\w+:)", comment)]
    # What is true of C++'s classes for a GPU alone is no sentence of this module.
    return "\n\n".join(part for part in paragraphs if part and "device.Thrust" not in part)


def names_of(declaration):
    """What a declaration declares: several members at most, of which none has parentheses."""
    declaration = declaration.split(";")[0]
    method = re.match(r"[^={]*?(\w+)\s*\(", declaration)
    if method:
        return [method.group(1)]
    declaration = re.sub(r"\{[^{}]*\}|=[^,;]*", "", declaration).strip()
    declaration = re.sub(r"<[^<>]*(<[^<>]*>)?[^<>]*>", "", declaration)
    return [match.group(1) for part in declaration.split(",") if (match := re.search(r"(\w+)(\[\d+\])?\s*$", part))]


def documented(text):
    """Pairs of a name and its sentence."""
    text = re.sub(r"template\s*<[^<>]*(<[^<>]*>)?[^<>]*>", "", text)
    scope, depth, group, comment = [], 0, None, None
    position = 0
    token = re.compile(
        r"(?P<block>/\*\*(?P<body>.*?)\*/)|(?P<after>///<(?P<short>[^\n]*))|(?P<open>///@\{)|(?P<close>///@\})"
        r"|(?P<type>\b(struct|class|enum class)\s+(EIGEN_ALIGN16\s+)?(?P<name>\w+)[^;{()]*\{)|(?P<brace>[{}])|(?P<end>;|,(?=\s*\n)|,\s*(?=///<))",
        re.S)
    begin = 0  # of the declaration
    pending = []
    for match in token.finditer(text):
        if match.start() < position:
            continue
        if match.group("block"):
            comment, begin = sentence(match.group("body")), match.end()
        elif match.group("after"):
            for name in pending or names_of(text[begin:match.start()]):
                yield "::".join(scope_names(scope) + [name]), sentence(match.group("short"))
            pending, begin = [], match.end()
        elif match.group("open"):
            group, begin = True, match.end()
        elif match.group("close"):
            group, comment, begin = None, None, match.end()
        elif match.group("type"):
            scope.append((match.group("name"), depth))
            depth += 1
            if comment:
                yield "::".join(scope_names(scope)), comment
            comment, begin, pending = None, match.end(), []
        elif match.group("brace") == "{":
            # The body of a function, or an initialiser, is part of the declaration.
            level, end = 1, match.end()
            while level and end < len(text):
                level += {"{": 1, "}": -1}.get(text[end], 0)
                end += 1
            if re.search(r"namespace[^;]*$", text[begin:match.start()]):
                begin = match.end()
                continue
            position = end
            if text[match.start() - 1] == ")" or re.search(r"\)\s*(const|noexcept|override)?\s*(:[^:].*)?$", text[begin:match.start()]):
                if comment and scope:
                    for name in names_of(text[begin:match.start()]):
                        yield "::".join(scope_names(scope) + [name]), comment
                comment, begin, pending = None, end, []
        elif match.group("brace") == "}":
            if scope:  # the last enumerator has no comma
                name = names_of(text[begin:match.start()])
                if comment and name:
                    yield "::".join(scope_names(scope) + name[:1]), comment
                scope.pop()
                depth -= 1
            comment, begin, pending = None, match.end(), []
        elif match.group("end"):
            if match.group("end") != ";" and text.count("(", begin, match.start()) != text.count(")", begin, match.start()):
                continue  # between parameters
            names = names_of(text[begin:match.start()])
            if scope and comment:
                for name in names:
                    yield "::".join(scope_names(scope) + [name]), comment
            elif not scope and comment:
                for name in names:
                    yield name, comment
            pending = names
            if not group:
                comment = None
            begin = match.end()


def scope_names(scope):
    return [name for name, _ in scope]


def main():
    output, headers = sys.argv[1], sys.argv[2:]
    table = {}
    for header in headers:
        with open(header, encoding="utf-8") as file:
            for name, text in documented(file.read()):
                table.setdefault(name, text)
    with open(output, "w", encoding="utf-8") as file:
        file.write("// Written by docstrings.py.\n")
        for name, text in sorted(table.items()):
            file.write('{"%s", R"doc(%s)doc"},\n' % (name, text))


if __name__ == "__main__":
    main()
