# SPDX-License-Identifier: BSD-3-Clause
"""Draws the pictures of docs/method.md, one per rule, as SVG beside this script.

    python3 docs/method/draw.py
"""
import math
import pathlib

FOLDER = pathlib.Path(__file__).parent
MESH, NET, NEW, BODY = "#888", "#1f5fa8", "#c8501e", "#2a7a2a"


class Picture:
    """Shapes in a drawing area of `width` x `height`, y upwards."""

    def __init__(self, width, height):
        self.width, self.height = width, height
        self.shapes = []

    def line(self, points, color, width=1.5, dash=""):
        path = " ".join(f"{x:g},{self.height - y:g}" for x, y in points)
        self.shapes.append(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="{width}" '
                           f'stroke-dasharray="{dash}"/>')

    def dot(self, point, color, text="", dx=6, dy=8, radius=4):
        x, y = point
        self.shapes.append(f'<circle cx="{x:g}" cy="{self.height - y:g}" r="{radius}" fill="{color}"/>')
        if text:
            self.text((x + dx, y + dy), text, color)

    def text(self, point, text, color="#222", size=13, anchor="start"):
        x, y = point
        self.shapes.append(f'<text x="{x:g}" y="{self.height - y:g}" fill="{color}" font-size="{size}" '
                           f'text-anchor="{anchor}">{text}</text>')

    def arrow(self, a, b, color):
        self.line([a, b], color, 2)
        angle = math.atan2(b[1] - a[1], b[0] - a[0])
        tips = [(b[0] - 8 * math.cos(angle + s), b[1] - 8 * math.sin(angle + s)) for s in (0.4, -0.4)]
        self.line([tips[0], b, tips[1]], color, 2)

    def write(self, name):
        text = (f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}" '
                f'font-family="sans-serif">\n<rect width="{self.width}" height="{self.height}" fill="white"/>\n'
                + "\n".join(self.shapes) + "\n</svg>\n")
        (FOLDER / name).write_text(text, encoding="utf-8")


def insertion():
    """Knot insertion at a border between two blocks."""
    p = Picture(520, 150)
    y = [60, 95, 60, 85, 55]
    x = [40, 140, 260, 380, 480]
    points = list(zip(x, y))
    p.line(points, MESH)
    names = ["q2", "q1", "p0", "p1", "p2"]
    for point, name in zip(points, names):
        p.dot(point, MESH, name)
    new = ((y[1] + y[3]) / 6 + 2 * y[2] / 3)
    at = (260, new)
    third = (2 * 260 / 3 + 380 / 3, 2 * y[2] / 3 + y[3] / 3)
    p.line([(260, 20), (260, 130)], "#ccc", 1, "4 3")
    p.text((266, 122), "border of two blocks", "#777", 11)
    p.dot(at, NEW, "")
    p.text((170, new + 14), "[1/6 2/3 1/6]", NEW, 12)
    p.dot(third, NEW, "[2/3 1/3]", -10, -18)
    p.write("insertion.svg")


def corner():
    """Products of the masks around a regular corner."""
    p = Picture(360, 260)
    step, left, low = 90, 60, 40
    for n in range(3):
        p.line([(left + n * step, low), (left + n * step, low + 2 * step)], MESH)
        p.line([(left, low + n * step), (left + 2 * step, low + n * step)], MESH)
    c = (left + step, low + step)
    t = step / 3
    for dx, dy, name in ((0, 0, "M x M"), (1, 0, "m x M"), (0, 1, "M x m"), (1, 1, "m x m")):
        p.dot((c[0] + dx * t, c[1] + dy * t), NEW)
        p.text((c[0] + dx * t + (8 if dx else -8), c[1] + dy * t + (8 if dy else -14)), name, NEW, 11,
               "start" if dx else "end")
    p.text((left, 14), "M = [1/6 2/3 1/6], m = [2/3 1/3]", "#555", 12)
    p.write("corner.svg")


def fan():
    """A fan of five and its control points."""
    p = Picture(360, 300)
    n, r, c = 5, 100, (180, 150)
    spokes = [(c[0] + r * math.cos(2 * math.pi * i / n + 0.3), c[1] + r * math.sin(2 * math.pi * i / n + 0.3))
              for i in range(n)]
    sectors = [(spokes[i][0] + spokes[(i + 1) % n][0] - c[0], spokes[i][1] + spokes[(i + 1) % n][1] - c[1])
               for i in range(n)]
    sectors = [(c[0] + 0.85 * (x - c[0]), c[1] + 0.85 * (y - c[1])) for x, y in sectors]
    for i in range(n):
        p.line([c, spokes[i], sectors[i], spokes[(i + 1) % n]], MESH)
        p.dot(spokes[i], MESH, "e" + str(i))
        p.dot(sectors[i], MESH, "f" + str(i))
        b = (c[0] + (spokes[i][0] - c[0]) * 0.37, c[1] + (spokes[i][1] - c[1]) * 0.37)
        d = (c[0] + (sectors[i][0] - c[0]) * 0.37, c[1] + (sectors[i][1] - c[1]) * 0.37)
        p.dot(b, NEW, "", radius=3)
        p.dot(d, NEW, "", radius=3)
    p.dot(c, NEW, "P", -16, 6)
    p.write("fan.svg")


def twist():
    """Border points in the tangent plane, the diagonal point out of it by the curvature."""
    p = Picture(420, 200)
    p.line([(30, 60), (330, 60), (400, 140), (100, 140), (30, 60)], MESH, 1)
    P, a, b = (150, 85), (255, 75), (205, 125)
    q = (a[0] + b[0] - P[0], a[1] + b[1] - P[1])
    p.line([P, a, q, b, P], NET, 1, "4 3")
    p.dot(P, BODY, "P", -16, -4)
    p.dot(a, NEW, "P + a", 6, -12)
    p.dot(b, NEW, "P + b", -20, 10)
    p.arrow(q, (q[0], q[1] + 55), NEW)
    p.text((q[0] + 8, q[1] + 40), "n II(a, b)", NEW)
    p.text((40, 40), "tangent plane of the body at its closest point", "#555", 12)
    p.write("twist.svg")


def layers():
    """What the body's rules changed fades out through the layers."""
    p = Picture(420, 220)
    heights = [0, 10, 24, 44, 72, 110, 160]
    for k, h in enumerate(heights):
        w = max(0, 1 - h / 150)
        bump = [(60 + 10 * i, 30 + h + 18 * w * math.exp(-((i - 14) / 5) ** 2)) for i in range(29)]
        p.line([(60, 30 + h), (340, 30 + h)], "#ccc", 1)
        p.line(bump, BODY if k == 0 else NET, 2 if k == 0 else 1.3)
    p.text((350, 26), "wall, d = 0", BODY, 12)
    p.text((350, 186), "w = 0", NET, 12)
    p.arrow((40, 30), (40, 185), "#555")
    p.text((14, 190), "d", "#555")
    p.write("layers.svg")


def crease():
    """Columns above a crease keep their points and fade."""
    p = Picture(460, 240)
    corner_point = (180, 60)
    p.line([(180, 10), corner_point, (440, 60)], BODY, 2.5)
    for k in range(1, 6):
        s = 14 * k + 2 * k * k
        w = max(0, 1 - k / 4)
        inner = (180 - s, 60 + s)
        rounded = (180 - s + 10 * (1 - w), 60 + s - 10 * (1 - w))
        p.line([(180 - s, 10), (inner[0], inner[1] - 26), rounded, (inner[0] + 26, inner[1]), (440, 60 + s)], NET, 1.2)
        p.dot(inner, MESH, "", radius=3)
        p.dot(rounded, NEW, "", radius=3)
    p.text((190, 38), "crease", BODY, 12)
    p.text((200, 222), "kept near the crease, smooth far above it", "#555", 12)
    p.write("crease.svg")


def spacing():
    """The first inserted layer at the wall."""
    p = Picture(420, 120)
    p.line([(40, 30), (40, 100)], BODY, 3)
    p.line([(40, 60), (380, 60)], MESH)
    for x, name in ((40, "p0"), (220, "p1"), (380, "p2")):
        p.dot((x, 60), MESH, name, 6 if x > 40 else -22, -22)
    for c, name, dy in ((2 / 3, "c = 2/3", -24), (0.85, "c = 0.85", 16)):
        p.dot((40 + (1 - c) * 180, 60), NEW, name, -14, dy)
    p.text((40, 10), "wall", BODY, 12, "middle")
    p.write("spacing.svg")


def far_field():
    """The first layer of the extension takes the distance of the last layers before it."""
    p = Picture(460, 140)
    p.line([(220, 20), (220, 120)], "#999", 1, "4 3")
    x = [40, 110, 165, 200, 220]
    p.line([(40, 70), (440, 70)], MESH)
    for a in x[:-1]:
        p.dot((a, 70), NET, "", radius=3)
    p.dot((220, 70), NET)
    p.dot((240, 70), NEW, "d", -2, 10)
    p.dot((420, 70), MESH)
    p.line([(200, 50), (220, 50)], NET, 2)
    p.line([(220, 50), (240, 50)], NEW, 2)
    p.text((206, 34), "d", NET)
    p.text((226, 34), "d", NEW)
    p.text((60, 110), "cuboid around the body", "#555", 12)
    p.text((280, 110), "extension", "#555", 12)
    p.write("far_field.svg")


def node():
    """A singular node: the star of a vertex where four blocks meet like the cells of a tetrahedron."""
    p = Picture(340, 260)
    c = (160, 120)
    ends = [(160, 240), (40, 60), (280, 60), (190, 150)]
    for n, e in enumerate(ends):
        p.line([c, e], NEW, 3 if n < 3 else 1.5, "" if n < 3 else "5 3")
        p.dot(e, MESH)
    for i in range(4):
        for j in range(i):
            f = ((ends[i][0] + ends[j][0]) * 0.62 - 0.24 * c[0], (ends[i][1] + ends[j][1]) * 0.62 - 0.24 * c[1])
            p.line([ends[i], f, ends[j]], MESH, 1)
    p.dot(c, NEW)
    p.text((160, 12), "extraordinary edges of four directions end in one node", "#555", 10, "middle")
    p.write("node.svg")


if __name__ == "__main__":
    for draw in (insertion, corner, fan, twist, layers, crease, spacing, far_field, node):
        draw()
