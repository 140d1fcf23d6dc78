"""What MkDocs adds to docs/: README as the first page, a page per figure, the API reference, and the report.

The Markdown in docs/ is written for a code forge, so it links to files beside docs/. On the site, a link to a
figure or a CSV leads to a copy of it, one to another document to its page, and one to code is text only.
"""

import posixpath
import re
import tempfile
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files
from mkdocs.structure.nav import Link, Navigation

from crawler_bench.report.figures import COMMANDS, described, pictures
from crawler_bench.report.page.folders import find_folders
from crawler_bench.report.page.write import write_report

ROOT = Path(__file__).parents[1]
DOCUMENTS = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
COPIED = (".png", ".gif", ".csv")
WINGS = {
    "Environment": "crawler_bench.envs", "Physics": "crawler_bench.physics", "Agents": "agents",
    "Runs": "crawler_bench.runs", "Gait metrics": "crawler_bench.gait",
    "Statistics": "crawler_bench.statistics",
    "Configuration": "crawler_bench.config", "Paper": "crawler_bench.paper",
    "Benchmark": "crawler_bench.benchmark", "Readings": "crawler_bench.readings",
    "Output": "crawler_bench.output", "Report": "crawler_bench.report",
}  # fmt: skip
_SEARCH = 'data-md-component="search" role="dialog"'
_NOTEBOOK_LINK = re.compile(r'href="(\w+)\.md')
_LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")


def on_files(files: Files, config: Any) -> Files:
    """Add every generated page and every file that the pages show."""
    for name, page in DOCUMENTS.items():
        files.append(File.generated(config, page, content=_relinked((ROOT / name).read_text(), ROOT / name)))
    pages = _figure_pages() | _reference_pages()
    for name, content in pages.items():
        files.append(File.generated(config, name, content=content))
    for path in _results():
        for each in sorted(path.iterdir()):
            if each.suffix in COPIED:
                files.append(
                    File.generated(config, each.relative_to(ROOT).as_posix(), abs_src_path=str(each))
                )
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.html"
        write_report(find_folders([ROOT / "results"]), report)
        files.append(File.generated(config, "report.html", content=report.read_text(encoding="utf-8")))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Make links of docs/ fit the site."""
    source = page.file.abs_src_path
    return markdown if source is None or not source.endswith(".md") else _relinked(markdown, Path(source))


def on_post_page(output: str, **_: Any) -> str:
    """Mend what the plugins leave: no name for the search, links of the notebook to Markdown."""
    output = output.replace(_SEARCH, f'{_SEARCH} aria-label="Search"')
    return _NOTEBOOK_LINK.sub(r'href="../\1/', output)


def on_nav(nav: Navigation, **_: Any) -> Navigation:
    """Lead to the playground and the report, which are no pages of MkDocs."""
    nav.items[1:1] = [Link("Playground", "playground/index.html"), Link("Report", "report.html")]
    return nav


def _results() -> list[Path]:
    return sorted(path for path in (ROOT / "results").iterdir() if path.is_dir() and path.name != "runs")


def _relinked(markdown: str, document: Path) -> str:
    """Markdown with every link to a file beside docs/ replaced."""

    def replace(match: re.Match[str]) -> str:
        sign, text, link = match.groups()
        path, _, anchor = link.partition("#")
        if not path or re.match(r"\w+:", path):
            return match[0]
        target = (document.parent / path).resolve()
        if not target.is_relative_to(ROOT):
            return match[0]
        name = target.relative_to(ROOT).as_posix()
        if name in DOCUMENTS:
            place = DOCUMENTS[name]
        elif name.startswith("docs/"):
            place = name.removeprefix("docs/")
        elif target.suffix in COPIED and target.is_file():
            place = name
        else:
            return text
        here = (
            posixpath.dirname(document.relative_to(ROOT / "docs").as_posix())
            if document.parent != ROOT
            else ""
        )
        return f"{sign}[{text}]({posixpath.relpath(place, here or '.')}{'#' if anchor else ''}{anchor})"

    return _LINK.sub(replace, markdown)


def _figure_pages() -> dict[str, str]:
    """A page per figure: what it shows, how it was made; and one that shows them all."""
    pages, gallery = {}, ["# Figures\n", "Every figure, with what it shows and how it was made."]
    for folder in _results():
        found = list(pictures(folder, folder.name))
        if found:
            gallery.append(f"\n## {folder.name.capitalize()}\n\n<div class='gallery' markdown>\n")
        for name, words, path in found:
            page = f"{folder.name}-{name}"
            pages[f"figures/{page}.md"] = _figure_page(folder.name, name, path)
            gallery.append(
                f"[![{words.title}](../results/{folder.name}/{name}.png)<br>{words.title}]({page}.md)\n"
            )
        if found:
            gallery.append("</div>")
    return pages | {"figures/index.md": "\n".join(gallery) + "\n"}


def _figure_page(kind: str, name: str, path: Path) -> str:
    words = described(kind, name)
    lines = [
        f"# {words.title}\n",
        words.shows,
        f"\n![{words.title}](../results/{kind}/{path.name})\n",
        "## How it was made\n",
    ]
    if kind in COMMANDS:
        lines.append(f"* Command: `{COMMANDS[kind]}`")
    if words.code:
        module, _, function = words.code.partition(":")
        dotted = module.removesuffix(".py").replace("/", ".")
        wing = next((title for title, package in WINGS.items() if dotted.startswith(package)), None)
        where = f"`{module}`, function `{function}`"
        lines.append(
            f"* Drawn by [{where}](../reference/{_slug(wing)}.md#{dotted}.{function})"
            if wing
            else f"* Drawn by {where}"
        )
    drawn = [f"[{each}](../results/{kind}/{each})" for each in words.data if (path.parent / each).is_file()]
    lines.append(
        f"* Data: {', '.join(drawn) if drawn else 'read from the run folders when the results are written'}"
    )
    lines.append(f"* As vector graphics: `results/{kind}/{name}.svg`")
    return "\n".join(lines) + "\n"


def _slug(title: str | None) -> str:
    return str(title).lower().replace(" ", "-")


def _reference_pages() -> dict[str, str]:
    """The API reference: a page per package, from its docstrings."""
    pages, index = {}, ["# Reference\n", "Every public module, from its docstrings.\n"]
    for title, package in WINGS.items():
        folder = ROOT / package.replace(".", "/")
        modules = sorted(
            ".".join(path.relative_to(ROOT).with_suffix("").parts)
            for path in folder.rglob("*.py")
            if not path.name.startswith("__")
        )
        pages[f"reference/{_slug(title)}.md"] = f"# {title}\n\n" + "\n".join(
            f"::: {name}\n" for name in modules
        )
        index.append(f"* [{title}]({_slug(title)}.md): `{package}`")
    return pages | {"reference/index.md": "\n".join(index) + "\n"}
