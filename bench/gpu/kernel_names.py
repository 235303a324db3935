# SPDX-License-Identifier: Apache-2.0
"""Short names of kernels, from those of the C++ functions that nvcc makes of them."""

import re


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


def without_operators(kernel):
    """Without the list of operators, which is the same in all kernels."""
    return re.sub(r"<StarOperators<.*> >", "<AllOperators>>", kernel)


def short(name):
    """reduce_kernel<R, F>(...) and spread_reduce_kernel<R, F>(...) are printed as F, as are for_each_kernel<StoreResult<R, F>>(...) and team_kernel;
    scan_kernel<F, ...>(...) and steps_kernel likewise."""
    name = re.sub(r"\b(tetune|backend|(sweep|coloring|csr|minimize_angle_cost)_detail)::", "", name)
    match = re.match(r"void ([\w:]+)<(.*?)>\(", name)
    if not match:
        return name
    kind, rest = match.groups()
    parts = arguments_of(rest)
    if kind in ("scan_kernel", "steps_kernel"):
        return without_operators(parts[0])
    if kind in ("for_each_kernel", "team_kernel"):
        stored = re.fullmatch(r"StoreResult<(.*?) ?>", parts[0])
        return without_operators(arguments_of(stored.group(1))[1] if stored else parts[0])
    if kind in ("reduce_kernel", "spread_reduce_kernel"):
        return without_operators(parts[1])
    if kind.startswith("cub"):
        return "CUB: " + kind.rsplit("::", 1)[1]
    return f"{kind}<{rest[:60]}>"
