"""Puts the guide and the reference of scenes together for mdBook: ``book.py FOLDER``.

Pictures are copied, and what else lies outside of the guide is linked in the repository.
"""

import os
import re
import shutil
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
GUIDE = ROOT / "docs/guide/src"
REFERENCE = ROOT / "scenes/README.md"
# Text, target and anchor of a link or picture.
LINK = re.compile(r"(?<=\]\()([^)#\s]+)(#[^)\s]*)?(?=\))")


def main() -> None:
    book = Path(sys.argv[1])
    source = book / "src"
    shutil.rmtree(book, ignore_errors=True)
    shutil.copytree(GUIDE, source)
    settings = (ROOT / "docs/guide/book.toml").read_text()
    (book / "book.toml").write_text(settings)
    repository = tomllib.loads(settings)["output"]["html"]["git-repository-url"]
    pages = {path: source / path.relative_to(GUIDE) for path in GUIDE.rglob("*.md")}
    pages[REFERENCE] = source / "reference.md"
    for path, page in pages.items():
        page.write_text(relinked(path, page, pages, repository))
    with (source / "SUMMARY.md").open("a") as summary:
        summary.write("- [The language of scenes](reference.md)\n")


def relinked(path: Path, page: Path, pages: dict[Path, Path], repository: str) -> str:
    """The text of a page with its links as they are in the book."""

    def link(found: re.Match[str]) -> str:
        target, anchor = found[1], found[2] or ""
        if re.match(r"[a-z]+:", target):
            return found[0]
        file = (path.parent / target).resolve()
        if not file.exists():
            sys.exit(f"{path.relative_to(ROOT)}: {target} is not there")
        if file in pages:
            there = pages[file]
        elif file.suffix in (".png", ".svg", ".gif"):
            there = pages[REFERENCE].parent / "pictures" / file.name
            there.parent.mkdir(exist_ok=True)
            shutil.copy(file, there)
        else:
            return f"{repository}/blob/main/{file.relative_to(ROOT).as_posix()}{anchor}"
        return Path(os.path.relpath(there, page.parent)).as_posix() + anchor

    return LINK.sub(link, path.read_text())


if __name__ == "__main__":
    main()
