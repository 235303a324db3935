# SPDX-License-Identifier: Apache-2.0
"""Pages of the public headers, from the XML that Doxygen makes of them."""

import html
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from itertools import groupby
from pathlib import Path

DOXYFILE = """
INPUT = {headers}
OUTPUT_DIRECTORY = {out}
GENERATE_XML = YES
GENERATE_HTML = NO
GENERATE_LATEX = NO
XML_PROGRAMLISTING = NO
FILE_PATTERNS = *.hpp
EXTRACT_ALL = YES
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = TETUNE_API=
QUIET = YES
WARN_AS_ERROR = FAIL_ON_WARNINGS
"""
# Doxygen's elements that HTML has too.
TAGS = {"para": "p", "computeroutput": "code", "emphasis": "em", "itemizedlist": "ul", "listitem": "li"}


def pages(headers):
    """For each header its name and page, in Markdown."""
    with tempfile.TemporaryDirectory() as out:
        subprocess.run(["doxygen", "-"], input=DOXYFILE.format(headers=headers, out=out), text=True, check=True)
        compounds = {f.stem: ET.parse(f).getroot().find("compounddef") for f in Path(out, "xml").glob("*.xml")
                     if f.stem not in ("index", "Doxyfile")}
    entries = {}
    for entry in (*(c for c in compounds.values() if c.get("kind") in ("class", "struct")),
                  *compounds["namespacetetune"].iterfind("sectiondef/memberdef")):
        entries.setdefault(Path(entry.find("location").get("file")).name, []).append(entry)
    for own in entries.values():
        own.sort(key=line)
    return Writer(entries).pages


def line(entry):
    return int(entry.find("location").get("line"))


def name_of(entry):
    return (entry.findtext("name") or entry.findtext("compoundname")).split("::")[-1]


class Writer:
    def __init__(self, entries):
        self._place = {}  # of each id of Doxygen's: page and anchor
        for header, own in entries.items():
            for entry in own:
                self._place[entry.get("id")] = f"{Path(header).stem}.html#{name_of(entry)}"
                for inner in (*entry.iter("memberdef"), *entry.iter("enumvalue")):
                    self._place.setdefault(inner.get("id"), f"{Path(header).stem}.html#{name_of(entry)}.{name_of(inner)}")
        self.pages = {}
        for header, own in entries.items():
            sections = [self._section(name, list(same)) for name, same in groupby(own, name_of)]
            self.pages[header] = f"# {header}\n\n```cpp\n#include <tetune/{header}>\n```\n\n" + "\n\n".join(sections)

    def _section(self, name, same):
        """A type, a constant, or the functions of one name."""
        title = f"{name}()" if same[0].get("kind") == "function" else name
        parts = [f"## {title} {{#{name}}}"]
        for entry in same:
            parts += [f'<pre class="declaration"><code>{self._declaration(entry)}</code></pre>', self._text(entry)]
            if entry.get("kind") in ("class", "struct"):
                members = entry.findall("sectiondef/memberdef[@prot='public']")
                parts.append(self._members(name, sorted(members, key=line)))
            elif entry.get("kind") == "enum":
                rows = [(f"{name}.{name_of(v)}", name_of(v), self._text(v)) for v in entry.findall("enumvalue")]
                parts.append(listed(rows))
        return "\n\n".join(p for p in parts if p)

    def _declaration(self, entry):
        kind, name = entry.get("kind"), f"<b>{name_of(entry)}</b>"
        if kind in ("class", "struct"):
            bases = [f"public {self._inline(b)}" for b in entry.findall("basecompoundref")]
            return f"{kind} {name}" + (f" : {', '.join(bases)}" if bases else "")
        if kind == "enum":
            return f"enum class {name}"
        if kind == "typedef":
            return f"using {name} = {self._type(entry)}"
        if kind == "variable":
            value = self._inline(entry.find("initializer"))
            return f"{self._type(entry)} {name}" + (f" {value}" if value.startswith("=") else value)
        given = []
        for p in entry.findall("param"):
            default = self._inline(p.find("defval"))
            words = [self._type(p), p.findtext("declname") or "", f"= {default}" if default else ""]
            given.append(" ".join(w for w in words if w))
        after = "".join(f" {word}" for word in ("const", "noexcept") if entry.get(word) == "yes")
        return f"{self._type(entry)} {name}({', '.join(given)}){after}".strip()

    def _type(self, entry):
        text = self._inline(entry.find("type"))  # Doxygen sets it apart: "std::vector< Index > &"
        for apart, together in (("&lt; ", "&lt;"), (" &gt;", "&gt;"), (" &amp;", "&amp;"), (" *", "*")):
            text = text.replace(apart, together)
        return text

    def _members(self, owner, members):
        rows = []
        for _, same in groupby(members, line):  # `double min = 0, max = 0;` is one line
            first, *others = list(same)
            shown = self._declaration(first)
            for m in others:
                value = self._inline(m.find("initializer"))
                shown += f', <b id="{owner}.{name_of(m)}">{name_of(m)}</b> {value}'.rstrip()
            rows.append((f"{owner}.{name_of(first)}", shown, "".join(self._text(m) for m in (first, *others))))
        return listed(rows)

    def _text(self, entry):
        return "".join(self._inline(entry.find(d)) for d in ("briefdescription", "detaileddescription")).strip()

    def _inline(self, element):
        """The words of an element, as HTML."""
        if element is None:
            return ""
        parts = [html.escape(element.text or "", quote=False)]
        for child in element:
            inner = self._inline(child)
            if child.tag == "ref" and child.get("refid") in self._place:
                inner = f'<a href="{self._place[child.get("refid")]}">{inner}</a>'
            elif child.tag in TAGS:
                inner = f"<{TAGS[child.tag]}>{inner}</{TAGS[child.tag]}>"
            elif child.tag != "ref":
                raise ValueError(f"Doxygen's <{child.tag}> in a public header: teach docs/site/cpp_api.py to write it")
            parts += [inner, html.escape(child.tail or "", quote=False)]
        return "".join(parts)


def listed(rows):
    """Members: anchor, declaration, what it is."""
    items = [f'<dt id="{anchor}"><code>{shown}</code></dt>\n<dd>{text}</dd>' for anchor, shown, text in rows]
    return '<dl class="members">\n' + "\n".join(items) + "\n</dl>" if items else ""
