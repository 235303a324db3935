# SPDX-License-Identifier: Apache-2.0
"""Short names of kernels, from those of the C++ functions that nvcc makes of them, as c++filt, the simulator of PTX and
ncu print them: the same name for the same kernel."""

import re

MAX_LENGTH = 70


def arguments_of(rest):
    """The arguments of a template, from the text between its angle brackets."""
    depth, parts, part = 0, [], ""
    for c in rest:
        depth += {"<": 1, ">": -1}.get(c, 0)
        if c == "," and depth == 0:
            parts.append(part.strip())
            part = ""
        else:
            part += c
    return [*parts, part.strip()]


def split_template(name):
    """A template and its arguments; none where the name is not that of an instance of a template."""
    match = re.fullmatch(r"([\w:]+)<(.*)>", name)
    return (match[1], arguments_of(match[2])) if match else (name, [])


def normalized(name):
    """Without namespaces of the library, and with one spelling of brackets and truth values: ncu prints false as 0."""
    name = re.sub(r"\b(?:tetune|backend|\w+_detail)::", "", name)
    name = re.sub(r"> +(?=>)", ">", name)
    for number, word in (("0", "false"), ("1", "true")):
        name = re.sub(rf", (?:\(bool\))?{number}(?=[,>])", f", {word}", name)
    return name


def without_operators(kernel):
    """Without the list of operators and the type of numbers, which are the same in all kernels that have such lists."""
    return re.sub(r"StarProposals<StarOperators<[^<>]*>[^<>]*>", "StarProposals<AllOperators>", kernel)


def shortened(name, length=MAX_LENGTH):
    """Without the last arguments where the name is longer."""
    kind, arguments = split_template(name)
    if len(name) <= length or not arguments:
        return name
    if len(arguments) == 1:
        return f"{kind}<{shortened(arguments[0], length - len(kind) - 2)}>"
    for count in range(len(arguments) - 1, 0, -1):
        fewer = f"{kind}<{', '.join(arguments[:count])}, ...>"
        if len(fewer) <= length:
            return fewer
    return f"{kind}<{shortened(arguments[0], length - len(kind) - 7)}, ...>"


def short(name):
    """F for a kernel of the backend that calls F: reduce_kernel<R, F>(...), spread_reduce_kernel<R, F>(...),
    for_each_kernel<F>(...), team_kernel<SIZE, F>(...), also where F is that of StoreResult<R, F>,
    ordered_kernel<EvaluateInOrder<R, F>>(...), scan_kernel<F, ...>(...) and steps_kernel<F, ...>(...)."""
    name = normalized(name)
    match = re.match(r"void ([\w:]+)<(.*?)>\(", name)
    if not match:
        return name
    kind, rest = match.groups()
    parts = arguments_of(rest)
    if kind in ("scan_kernel", "steps_kernel"):
        function = parts[0]
    elif kind in ("for_each_kernel", "team_kernel", "ordered_kernel"):
        outer, inner = split_template(parts[-1])
        function = inner[1] if outer in ("StoreResult", "EvaluateInOrder") else parts[-1]
    elif kind in ("reduce_kernel", "spread_reduce_kernel"):
        function = parts[1]
    elif kind.startswith("cub"):
        return "CUB: " + kind.rsplit("::", 1)[1]
    else:
        function = f"{kind}<{rest}>"
    return shortened(without_operators(function))
