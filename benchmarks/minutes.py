"""What a run that goes on for hours is looked at for, minute by minute: what it needs of the machine, and charts of that."""
import hashlib
import json
import pathlib
import time


class LineReader:
    """The whole lines that have come to a file since the last call."""

    def __init__(self, file):
        self.file, self.rest = open(file), ""

    def read(self):
        *lines, self.rest = (self.rest + self.file.read()).split("\n")
        return lines


class FixReader(LineReader):
    def read(self):
        return [json.loads(line) for line in super().read()]


def look_at(process):
    """Memory of its own (MB), threads and open files of a process."""
    folder = pathlib.Path(f"/proc/{process.pid}")
    status = dict(line.split(":", 1) for line in (folder / "status").read_text().splitlines())
    return int(status["RssAnon"].split()[0]) / 1024, int(status["Threads"]), len(list((folder / "fd").iterdir()))


def machine_pace(work=bytes(20_000_000)):
    """What the same work takes of this thread's time on a processor (ms): how fast the machine is at the moment, whoever else uses it."""
    begin = time.thread_time()
    hashlib.sha1(work).digest()
    return 1e3 * (time.thread_time() - begin)


def draw(columns, rows, shown, file):
    """One small chart of a column below the other. The first column of every row is its minute."""
    width, height, left = 760, 110, 70
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width + left + 20}" height="{len(shown) * (height + 40) + 30}" font-family="sans-serif" font-size="13">',
             '<rect width="100%" height="100%" fill="white"/>']
    last = max(row[0] for row in rows)
    for i, name in enumerate(shown):
        values = [row[columns.index(name)] for row in rows]
        top, most = 30 + i * (height + 40), max([value for value in values if value == value] + [1e-9]) * 1.1
        points = " ".join(f"{left + width * row[0] / max(last, 1):.1f},{top + height - height * value / most:.1f}" for row, value in zip(rows, values) if value == value)
        parts += [f'<text x="{left}" y="{top - 6}">{name}</text>', f'<path d="M{left},{top} V{top + height} H{left + width}" stroke="#888" fill="none"/>',
                  f'<text x="{left - 6}" y="{top + 10}" text-anchor="end">{most / 1.1:.4g}</text>', f'<text x="{left - 6}" y="{top + height}" text-anchor="end">0</text>',
                  f'<polyline points="{points}" fill="none" stroke="#06c" stroke-width="1.5"/>']
    parts += [f'<text x="{left + width}" y="{len(shown) * (height + 40) + 20}" text-anchor="end">{last} minutes</text>', "</svg>"]
    file.write_text("\n".join(parts) + "\n")
