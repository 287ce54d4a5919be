# SPDX-License-Identifier: MIT
"""stamp.py - writes into a PNG which data it was drawn from, and tells whether the data are still the same

    stamp.py FILE.png DATA...

The stamp is a text chunk, "Data", of names and the beginnings of their SHA-256: "methods.csv 0123456789abcdef, ...".
Nothing but Python's own modules is needed.
"""
import csv
import hashlib
import os
import struct
import sys
import zlib

SIGNATURE = b"\x89PNG\r\n\x1a\n"
KEY = b"Data\0"


def chunks(image):
    """(type, content) of each chunk"""
    place = len(SIGNATURE)
    while place < len(image):
        (length,) = struct.unpack(">I", image[place:place + 4])
        yield image[place + 4:place + 8], image[place + 8:place + 8 + length]
        place += 12 + length


def read_bytes(path):
    with open(path, "rb") as file:
        return file.read()


def describe(path):
    return f"{os.path.basename(path)} {hashlib.sha256(read_bytes(path)).hexdigest()[:16]}"


def stamp(path, data):
    """Writes the stamp in place of one that is there."""
    text = KEY + ", ".join(describe(one) for one in data).encode()
    kept = [(kind, content) for kind, content in chunks(read_bytes(path)) if not (kind == b"tEXt" and content.startswith(KEY))]
    with open(path, "wb") as file:
        file.write(SIGNATURE)
        for kind, content in [kept[0], (b"tEXt", text)] + kept[1:]:
            file.write(struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content)))


def mistakes(path, folder):
    """What is wrong with the stamp, the data being in `folder`: a list of sentences."""
    texts = [content[len(KEY):].decode() for kind, content in chunks(read_bytes(path)) if kind == b"tEXt" and content.startswith(KEY)]
    if not texts:
        return ["has no stamp: which data is it drawn from?"]
    found = []
    for part in texts[0].split(", "):
        data = os.path.join(folder, part.split()[0])
        if not os.path.exists(data):
            found.append(f"is drawn from {data}, which is not there")
        elif describe(data) != part:
            found.append(f"is drawn from another {data}")
    return found


def machine_of(table):
    """The processor that measured this table and the widest vectors that it has, by measured.csv beside it (measure.sh); or nothing."""
    listed = os.path.join(os.path.dirname(table), "measured.csv")
    if os.path.exists(listed):
        with open(listed, newline="") as file:
            for row in csv.DictReader(file):
                if row["file"] == os.path.basename(table):
                    return f"{row['processor']} (has {row['vectors']}), {row['measured']}"
    return ""


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    stamp(sys.argv[1], sys.argv[2:])
