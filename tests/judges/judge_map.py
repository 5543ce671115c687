"""Judges an exported map with PyYAML and Pillow, by the rules of ROS' map_server."""

import sys
from pathlib import Path

import yaml
from PIL import Image

description = Path(sys.argv[1])
about = yaml.safe_load(description.read_text())
image = Image.open(description.parent / about["image"])
assert image.format in ("PPM", "PNG") and image.mode == "L", (image.format, image.mode)
assert about["mode"] == "trinary" and about["negate"] == 0, about


def occupancy(column, row):
    share = (255 - image.getpixel((column, row))) / 255
    if share > about["occupied_thresh"]:
        return 100
    return 0 if share < about["free_thresh"] else -1


cells = [occupancy(column, row) for row in range(image.height) for column in range(image.width)]
counts = {value: cells.count(value) for value in (0, 100, -1)}
assert all(count > 100 for count in counts.values()), counts
# The robot began at the origin: the lower left pixel's corner is at `origin`.
x_m, y_m, yaw = about["origin"]
column = round(-x_m / about["resolution"])
row = image.height - 1 - round(-y_m / about["resolution"])
assert yaw == 0 and occupancy(column, row) == 0, (column, row)
print(f"map: {image.width} x {image.height} cells, {counts[0]} free, {counts[100]} occupied, {counts[-1]} unknown")
