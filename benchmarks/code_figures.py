#!/usr/bin/env python3
"""Figures of the code: how long it is, and how much of it is long, cast, constant or there twice.

python3 benchmarks/code_figures.py [COMMIT ...]
Of the files as they are, or of commits beside each other. Counted are src/, apps/ and python/, by text alone: a function is what stands between the braces
after a parameter list, lambdas count with the function around them.
"""
import argparse
import pathlib
import re
import subprocess
import sys

FOLDERS = ('src', 'apps', 'python')
STRETCH = 6  # lines
LONG_FUNCTION, LONG_FILE = 40, 300  # lines
ROOT = pathlib.Path(__file__).resolve().parent.parent


def git(*arguments):
    return subprocess.run(['git', '-C', str(ROOT), *arguments], capture_output=True, check=True, text=True).stdout


def sources(commit):
    """Name and text of each C++ file; without a commit, of the files as they are."""
    listed = git('ls-tree', '-r', '--name-only', commit, *FOLDERS) if commit else git('ls-files', *FOLDERS)
    for name in listed.splitlines():
        if name.endswith(('.cpp', '.hpp')):
            yield name, git('show', f'{commit}:{name}') if commit else (ROOT / name).read_text(encoding='utf-8')


def without_texts(code):
    """The code with comments and literals blanked out, line by line as before."""
    def blank(match):
        text = match.group(0)
        return re.sub(r'[^\n]', ' ', text) if text[0] == '/' else '""' + '\n' * text.count('\n')
    return re.sub(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'', blank, code, flags=re.S)


def function_lengths(code):
    """Lines of each function's body, its braces included."""
    lengths, depth, begin, statement = [], 0, None, ''
    heads = re.compile(r'\)\s*(const|noexcept|override|final|->[^;{}]*|:[^;]*)*\s*$', re.S)
    inside = None  # depth of the function that is being read
    for line_number, line in enumerate(code.splitlines()):
        for letter in line + '\n':
            if letter == '{':
                if inside is None and heads.search(statement) and not re.search(r'\b(namespace|class|struct|enum|union)\b[^()]*$', statement):
                    inside, begin = depth, line_number
                depth += 1
                statement = ''
            elif letter == '}':
                depth -= 1
                if inside == depth:
                    lengths.append(line_number - begin + 1)
                    inside = None
                statement = ''
            elif letter == ';':
                statement = ''
            else:
                statement += letter
    return lengths


def stretches_there_twice(files):
    """Stretches of six or more lines that occur more than once, each counted once for every place but the first."""
    seen, count = {}, 0
    for _, code in files:
        lines = [line.strip() for line in code.splitlines()]
        lines = [line for line in lines if line and not line.startswith(('//', '#include')) and line not in ('}', '{', '};')]
        going_on = None
        for i in range(len(lines) - STRETCH + 1):
            window = tuple(lines[i:i + STRETCH])
            twice = window in seen
            if twice and going_on != i - 1:
                count += 1
            if twice:
                going_on = i
            seen.setdefault(window, i)
    return count


def figures(commit):
    files = list(sources(commit))
    codes = [(name, without_texts(text)) for name, text in files]
    lengths = [length for _, code in codes for length in function_lengths(code)]
    constant = re.compile(r'\bconstexpr\b[^;(]*=\s*[-{]?\s*[\d.]')
    return {
        'files': len(files),
        'lines': sum(text.count('\n') for _, text in files),
        f'files over {LONG_FILE} lines': sum(text.count('\n') > LONG_FILE for _, text in files),
        'functions': len(lengths),
        f'functions over {LONG_FUNCTION} lines': sum(length > LONG_FUNCTION for length in lengths),
        'longest function, lines': max(lengths),
        'casts': sum(len(re.findall(r'\b(?:static|reinterpret|const|dynamic)_cast<', code)) for _, code in codes),
        'numbers named in a source (constexpr)': sum(len(constant.findall(code)) for name, code in codes if name.endswith('.cpp')),
        f'stretches of {STRETCH} lines there twice': stretches_there_twice(files),
        'loops of Levenberg and Marquardt': sum(bool(re.search(r'lambda\s*\*=|damping\s*\*=|damping \*=', code)) for _, code in codes),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('commits', nargs='*', metavar='COMMIT')
    commits = parser.parse_args().commits
    try:
        columns = [figures(commit) for commit in commits] or [figures(None)]
    except subprocess.CalledProcessError as error:
        sys.exit(f'code_figures: {error.stderr.strip()}')
    print('| | ' + ' | '.join(commits or ['now']) + ' |')
    print('|---' * (1 + len(columns)) + '|')
    for what in columns[0]:
        print(f'| {what} | ' + ' | '.join(str(column[what]) for column in columns) + ' |')


if __name__ == '__main__':
    main()
