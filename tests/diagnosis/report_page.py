"""A report as its reader's browser parses it."""

from html.parser import HTMLParser


class Page(HTMLParser):
    """A page's texts by tag, attributes, and the tags left open."""

    def __init__(self, text: str):
        super().__init__()
        self.open: list[str] = []
        self.texts: dict[str, list[str]] = {}
        self.attributes: list[tuple[str, str, str]] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in ("meta", "img"):
            self.open.append(tag)
            self.texts.setdefault(tag, []).append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open:
            self.texts[self.open[-1]][-1] += data

    def of(self, tag):
        return self.texts.get(tag, [])

    @property
    def text(self) -> str:
        return " ".join(" ".join(texts) for tag, texts in self.texts.items() if tag not in ("style", "script", "html"))
