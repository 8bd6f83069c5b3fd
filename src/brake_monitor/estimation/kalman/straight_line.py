"""Loops over small matrices → one straight run of arithmetic: the same equations, many times faster in plain Python.

A function of numbers, written with loops and lists as the mathematics is, is called once with symbols in place of the
numbers. What it does with them is written down as Python source without loops, lists or indices in between, in which
everything that is multiplied by a constant zero has vanished and nothing is computed twice, and compiled:

    def predict(x, p):                                   def straight(arg0, arg1):
        f = [[1.0, 0.1], [0.0, 1.0]]                         (a0, a1,) = arg0
        return product(f, x), product(f, p)       →          ...
                                                             return [(a0 + (0.1 * a1)), a1], ...

The sums are taken in the order of the loops, so both give the same numbers. What a branch would depend on is not known
while the function is followed: a flag has to be an argument that is multiplied by, 0 or 1, or the function is followed
once for each of its values. A comparison (`<=`, joined by `&`) may be returned for others to branch on.

The compiled function works on whatever adds and multiplies: with arrays in place of numbers it computes many at once.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from itertools import count
from typing import Any, NamedTuple

LONGEST_EXPRESSION = 400  # characters; the compiler nests no deeper than a few hundred brackets
NEUTRAL = {"+": 0.0, "-": 0.0, "*": 1.0, "/": 1.0}  # on the right of these it changes nothing


def _noted(operator: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """What an operator makes of a symbol and something else, and of something else and a symbol."""

    def with_right(symbol: "Symbol", other: Any) -> Any:
        return symbol.journal.note(operator, symbol, other)

    def with_left(symbol: "Symbol", other: Any) -> Any:
        return symbol.journal.note(operator, other, symbol)

    return with_right, with_left


class Symbol:
    """A number that is not known yet: an argument, or what an operation makes of two others."""

    __slots__ = ("journal", "left", "name", "operator", "right")

    def __init__(self, journal: "Journal", operator: str, left: Any, right: Any, name: str = "") -> None:
        self.journal = journal
        self.operator = operator
        self.left = left
        self.right = right
        self.name = name  # of an argument

    __add__, __radd__ = _noted("+")
    __sub__, __rsub__ = _noted("-")
    __mul__, __rmul__ = _noted("*")
    __truediv__, __rtruediv__ = _noted("/")
    __le__, __ge__ = _noted("<=")[0], _noted(">=")[0]
    __and__ = _noted("and")[0]

    def __neg__(self) -> Any:
        return self.journal.note("-", 0.0, self)

    def __bool__(self) -> bool:
        raise TypeError("what a branch depends on is not known while a function is followed")


class Named(NamedTuple):
    """Stands for an argument that has numbers as attributes: the function gets the NamedTuple of these names."""

    shape: Any


class Journal:
    """The operations so far, each once."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, object, object], Symbol] = {}

    def note(self, operator: str, left: Any, right: Any) -> Any:
        """What an operation makes of numbers of which not all are known. What 0 or 1 decides is no operation."""
        neutral, commutes = NEUTRAL.get(operator), operator in ("+", "*")
        if operator in ("*", "/") and (_is(left, 0.0) or (commutes and _is(right, 0.0))):
            return 0.0
        if operator == "-" and left is right:
            return 0.0
        if _is(right, neutral):
            return left
        if commutes and _is(left, neutral):
            return right
        if commutes and (operator, _key(right), _key(left)) in self._known:
            left, right = right, left  # the same number
        key = (operator, _key(left), _key(right))
        if key not in self._known:
            self._known[key] = Symbol(self, operator, left, right)
        return self._known[key]


def straight_line(function: Callable[..., Any], *examples: Any) -> Callable[..., Any]:
    """Compile what `function` does with arguments of the shapes of `examples`.

    An argument is a number, or a list, tuple or NamedTuple of arguments, or for `Named` any object with such numbers;
    so is the result, in which a NamedTuple becomes a tuple. TypeError when the function branches on a number.
    """
    heads, writer, result = _followed(function, examples)
    returned = writer.text(result)
    names = [f"arg{place}" for place in range(len(examples))]
    unpacked = [f"{head} = {name}" for head, name in zip(heads, names, strict=True)]
    body = "\n    ".join([*unpacked, *writer.lines, f"return {returned}"])
    made: dict[str, Any] = {}
    exec(f"def straight({', '.join(names)}):\n    {body}\n", made)  # made of operators and of our own names
    straight: Callable[..., Any] = made["straight"]
    return straight


def flat_source(function: Callable[..., Any], *examples: Any) -> str:
    """The same as the source of `straight(given, result)`: all numbers in one array, all results in another."""
    _, writer, result = _followed(function, examples)
    lines = [f"result[{place}] = {writer.text(value)}" for place, value in enumerate(_values(result))]
    arguments = [f"{one.name} = given[{place}]" for place, one in enumerate(writer.arguments) if writer.uses[one]]
    body = "\n    ".join([*arguments, *writer.lines, *lines])
    return f"def straight(given, result):\n    {body}\n"


def _followed(function: Callable[..., Any], examples: Sequence[Any]) -> tuple[Sequence[str], "_Writer", Any]:
    """The patterns of the arguments, the writer of what the function does, and its result."""
    writer = _Writer()
    heads, values = zip(*[writer.argument(example) for example in examples], strict=True)
    result = function(*values)
    writer.count_uses(result)
    return heads, writer, result


def _values(result: Any) -> Iterator[Any]:
    """Of nested lists and tuples, in order."""
    if isinstance(result, (list, tuple)):
        for part in result:
            yield from _values(part)
    else:
        yield result


class _Writer:
    """Symbols → source."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.arguments: list[Symbol] = []
        self._journal = Journal()
        self._argument_names = (f"a{number}" for number in count())
        self._object_names = (f"o{number}" for number in count())
        self._local_names = (f"t{number}" for number in count())
        self.uses: Counter[Symbol] = Counter()
        self._named: dict[Symbol, str] = {}

    def argument(self, example: Any) -> tuple[str, Any]:
        """The pattern that takes an argument apart, and the symbols in the shape of the argument."""
        if isinstance(example, Named):
            name = next(self._object_names)
            return name, example.shape(*(self._symbol(f"{name}.{one}") for one in example.shape._fields))
        if not isinstance(example, (list, tuple)):
            self.arguments.append(self._symbol(next(self._argument_names)))
            return self.arguments[-1].name, self.arguments[-1]
        parts = [self.argument(part) for part in example]
        symbols = [symbol for _, symbol in parts]
        shaped = type(example)(*symbols) if hasattr(example, "_fields") else type(example)(symbols)
        return f"({''.join(f'{pattern}, ' for pattern, _ in parts)})", shaped

    def _symbol(self, name: str) -> Symbol:
        return Symbol(self._journal, "", None, None, name)

    def count_uses(self, result: Any) -> None:
        """Note how often each symbol is needed."""
        waiting = list(_values(result))
        while waiting:
            value = waiting.pop()
            if isinstance(value, Symbol):
                self.uses[value] += 1
                if self.uses[value] == 1:
                    waiting += [value.left, value.right]

    def text(self, value: Any) -> str:
        """A value as an expression; what is needed more than once gets a name in a line of its own."""
        if isinstance(value, list):
            return f"[{', '.join(map(self.text, value))}]"
        if isinstance(value, tuple):
            return f"({''.join(f'{self.text(part)}, ' for part in value)})"
        if not isinstance(value, Symbol):
            return repr(float(value))
        if value.name and "." not in value.name:
            return value.name
        if value not in self._named:
            expression = value.name or f"({self.text(value.left)} {value.operator} {self.text(value.right)})"
            if self.uses[value] == 1 and len(expression) < LONGEST_EXPRESSION:
                return expression
            self._named[value] = next(self._local_names)
            self.lines.append(f"{self._named[value]} = {expression}")
        return self._named[value]


def _is(value: Any, number: float | None) -> bool:
    """Whether a value is this constant."""
    return not isinstance(value, Symbol) and bool(value == number)


def _key(value: Any) -> object:
    return id(value) if isinstance(value, Symbol) else float(value).hex()
