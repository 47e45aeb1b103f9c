"""The string literals of C++ files."""
import re

# A comment, a raw string, a string or a character; whichever starts first.
TOKEN = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(?P<mark>[^(]*)\((?P<raw>.*?)\)(?P=mark)"'
    r'|"(?P<text>(?:[^"\\\n]|\\.)*)"|\'(?:[^\'\\\n]|\\.)+\'',
    re.DOTALL)


def strings_in(source):
    """Place and text of every string literal, those of #include among them."""
    for match in TOKEN.finditer(source):
        text = match["raw"] if match["raw"] is not None else match["text"]
        if text is not None:
            yield match.start(), text


def strings(path):
    """Line number and text of every string literal of a file."""
    source = path.read_text()
    for at, text in strings_in(source):
        yield source.count("\n", 0, at) + 1, text
