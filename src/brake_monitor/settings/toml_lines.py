"""Where each key of a TOML text stands, so that an error can name its line (tomllib does not tell)."""

import re
import tomllib
from collections.abc import Mapping
from typing import NamedTuple

KeyPath = tuple[str | int, ...]  # table and key names; places in an array from 0

_TOKEN = re.compile(
    r"""
      (?P<comment>\#[^\n]*)
    | (?P<string>\"{3}(?:\\.|[^\\])*?\"{3,5} | '{3}.*?'{3,5} | "(?:\\.|[^"\\\n])*" | '[^'\n]*')
    | (?P<newline>\n)
    | (?P<punct>[][{},=.])
    | (?P<bare>[^\s\[\]{},=."'\#]+)
    """,
    re.VERBOSE | re.DOTALL,
)


class _Token(NamedTuple):
    kind: str
    text: str
    line: int


def key_lines(text: str) -> dict[KeyPath, int]:
    """Return the line (from 1) of every table, key and array entry of `text`, which tomllib must accept."""
    return _Scanner(text).lines


def line_of(lines: Mapping[KeyPath, int], key: KeyPath) -> int:
    """Return the line of a key, or of the nearest table above it that stands in the text."""
    while key and key not in lines:
        key = key[:-1]
    return lines.get(key, 1)


class _Scanner:
    """One pass over the tokens of a valid document; values are skipped, only places are kept."""

    def __init__(self, text: str) -> None:
        self.lines: dict[KeyPath, int] = {}
        self._tokens = list(_tokens(text))
        self._next = 0
        self._table_arrays: dict[KeyPath, int] = {}  # array of tables → place of its newest entry
        table: KeyPath = ()
        while (token := self._skip_newlines()) is not None:
            if token.text == "[" and token.kind == "punct":
                table = self._header()
            else:
                self._key_value(table)

    def _peek(self) -> _Token | None:
        return self._tokens[self._next] if self._next < len(self._tokens) else None

    def _take(self) -> _Token:
        token = self._tokens[self._next]
        self._next += 1
        return token

    def _skip_newlines(self) -> _Token | None:
        while (token := self._peek()) is not None and token.kind == "newline":
            self._next += 1
        return token

    def _accept(self, punct: str) -> bool:
        token = self._peek()
        found = token is not None and token.kind == "punct" and token.text == punct
        self._next += found
        return found

    def _keys(self) -> list[_Token]:
        keys = [self._take()]
        while self._accept("."):
            keys.append(self._take())
        return keys

    def _header(self) -> KeyPath:
        self._take()
        is_array = self._accept("[")
        keys = self._keys()
        self._next += 2 if is_array else 1
        path: KeyPath = ()
        for key in keys[:-1]:
            self.lines.setdefault((*path, _name(key)), keys[0].line)
            path = self._into_newest((*path, _name(key)))
        path = (*path, _name(keys[-1]))
        self.lines.setdefault(path, keys[0].line)
        if is_array:
            self._table_arrays[path] = self._table_arrays.get(path, -1) + 1
            path = (*path, self._table_arrays[path])
            self.lines[path] = keys[0].line
        return path

    def _into_newest(self, path: KeyPath) -> KeyPath:
        return (*path, self._table_arrays[path]) if path in self._table_arrays else path

    def _key_value(self, table: KeyPath) -> None:
        path = table
        for key in self._keys():
            path = (*path, _name(key))
            self.lines.setdefault(path, key.line)
        self._accept("=")
        self._value(path)

    def _value(self, path: KeyPath) -> None:
        if self._accept("{"):
            self._skip_newlines()
            while not self._accept("}"):
                self._key_value(path)
                self._separator()
        elif self._accept("["):
            place = 0
            self._skip_newlines()
            while not self._accept("]"):
                token = self._tokens[self._next]
                self.lines[(*path, place)] = token.line
                self._value((*path, place))
                self._separator()
                place += 1
        else:
            while (token_or_end := self._peek()) is not None and not _ends_value(token_or_end):
                self._next += 1

    def _separator(self) -> None:
        self._skip_newlines()
        self._accept(",")
        self._skip_newlines()


def _tokens(text: str) -> list[_Token]:
    tokens, line, counted = [], 1, 0
    for match in _TOKEN.finditer(text):
        line += text.count("\n", counted, match.start())
        counted = match.start()
        kind = match.lastgroup or ""
        if kind != "comment":
            tokens.append(_Token(kind, match.group(), line))
    return tokens


def _name(key: _Token) -> str:
    return str(tomllib.loads(f"key = {key.text}")["key"]) if key.kind == "string" else key.text


def _ends_value(token: _Token) -> bool:
    return token.kind == "newline" or (token.kind == "punct" and token.text in ",]}")
