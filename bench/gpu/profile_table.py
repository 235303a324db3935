# SPDX-License-Identifier: Apache-2.0
"""The table of ncu, one row per launch, as sums over the launches of each kernel."""

import collections
import csv
import math

from kernel_names import short

TIME = "gpu__time_duration.sum"
DRAM = "dram__bytes.sum"
REGISTERS = "launch__registers_per_thread"
WARPS = "sm__warps_active.avg.pct_of_peak_sustained_active"
LANES = "smsp__thread_inst_executed_per_inst_executed.ratio"
INSTRUCTIONS = "sm__inst_executed.avg.per_cycle_active"
L1_HITS = "l1tex__t_sector_hit_rate.pct"
METRICS = (TIME, DRAM, REGISTERS, WARPS, LANES, INSTRUCTIONS, L1_HITS)

# Seconds and bytes, by the names that versions of ncu have for their multiples.
UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "nsecond": 1e-9, "usecond": 1e-6, "msecond": 1e-3,
         "Kbyte": 1e3, "Mbyte": 1e6, "Gbyte": 1e9}


class Kernel:
    """The launches of a kernel, each {metric: value}, with times in seconds and traffic in bytes."""

    def __init__(self, launches):
        self.launches = launches
        self.seconds = self.total(TIME)
        self.longest = self.largest(TIME)

    def total(self, metric):
        return sum(launch[metric] for launch in self.launches)

    def largest(self, metric):
        return max(launch[metric] for launch in self.launches)

    def mean(self, metric):
        """Weighted by time, over the launches that have a value: an empty one has no active lanes."""
        valid = [launch for launch in self.launches if math.isfinite(launch[metric])]
        weights = sum(launch[TIME] for launch in valid)
        return sum(launch[TIME] * launch[metric] for launch in valid) / weights if weights else math.nan

    def record(self):
        """For JSON files."""
        values = {"launches": len(self.launches), "seconds": self.seconds, "longest_seconds": self.longest,
                  "registers": self.largest(REGISTERS), "active_lanes": self.mean(LANES),
                  "warps_active_percent": self.mean(WARPS), "instructions_per_cycle": self.mean(INSTRUCTIONS),
                  "l1_hits_percent": self.mean(L1_HITS), "dram_bytes": self.total(DRAM)}
        return {key: value if math.isfinite(value) else None for key, value in values.items()}


def ncu_command(ncu, program):
    """Runs a program, a list of arguments, under ncu. Clocks and caches are those of a run without it."""
    return [ncu, "--clock-control", "none", "--cache-control", "none", "--csv", "--page", "raw",
            "--metrics", ",".join(METRICS), *program]


def table_lines(text):
    """The lines of the table, among messages of ncu and of the program. Empty if there is none."""
    lines = text.splitlines()
    first = next((i for i, line in enumerate(lines) if line.startswith('"ID"')), len(lines))
    return [line for line in lines[first:] if line.startswith('"')]


def number(cell, unit):
    try:
        return float(cell.replace(",", "")) * UNITS.get(unit, 1)
    except ValueError:
        return math.nan


def read_kernels(text):
    """{short name: Kernel}, by time, from the output of ncu_command(). Empty if there is no table in it."""
    launches = collections.defaultdict(list)
    rows = csv.DictReader(table_lines(text))
    units = next(rows, None)
    for row in rows:
        launches[short(row["Kernel Name"])].append({m: number(row.get(m, ""), units.get(m)) for m in METRICS})
    kernels = [(name, Kernel(group)) for name, group in launches.items()]
    return dict(sorted(kernels, key=lambda item: -item[1].seconds))


def digits(value):
    if not math.isfinite(value):
        return "-"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.4g}"


def print_table(kernels, least=0.01):
    """Kernels with at least this part of the time, and the sum of all, as Markdown."""
    everything = Kernel([launch for kernel in kernels.values() for launch in kernel.launches])
    print("| kernel | launches | total, ms | longest launch, µs | registers | active lanes of 32 | warps active, % "
          "| instructions per cycle | DRAM, GB |\n" + "|---" * 9 + "|")
    rows = [(f"`{name}`", kernel) for name, kernel in kernels.items() if kernel.seconds >= least * everything.seconds]
    for name, k in [*rows, ("**all**", everything)]:
        values = [1e3 * k.seconds, 1e6 * k.longest, k.largest(REGISTERS), k.mean(LANES), k.mean(WARPS),
                  k.mean(INSTRUCTIONS), 1e-9 * k.total(DRAM)]
        print(f"| {name} | {len(k.launches)} | " + " | ".join(digits(value) for value in values) + " |")
