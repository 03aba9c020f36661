#!/usr/bin/env python3
"""between: put standard input into FILE between the lines <!-- NAME --> and <!-- end NAME -->.

   between.py FILE NAME"""
import sys


def main():
    path, name = sys.argv[1:]
    begin, end = f"<!-- {name} -->\n", f"<!-- end {name} -->\n"
    with open(path, encoding="utf-8") as file:
        text = file.read()
    if text.count(begin) != 1 or text.count(end) != 1:
        sys.exit(f"between: {path} has no place for {name}")
    before, rest = text.split(begin)
    new = before + begin + "\n" + sys.stdin.read().strip() + "\n\n" + end + rest.split(end)[1]
    with open(path, "w", encoding="utf-8") as file:
        file.write(new)


if __name__ == "__main__":
    main()
