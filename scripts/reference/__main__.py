"""Writes all generated sections: `python -m scripts.reference`."""

from scripts.reference.sections import ROOT, pages, renewed


def main() -> None:
    """Writes every page that holds a generated section."""
    for page in pages():
        text = page.read_text()
        if (new := renewed(text)) != text:
            page.write_text(new)
            print(page.relative_to(ROOT))


if __name__ == "__main__":
    main()
