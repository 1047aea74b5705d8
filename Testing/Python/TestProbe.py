# SPDX-License-Identifier: BSD-3-Clause
"""BSpline Volume Probe and BSpline Volume Isoparametric through their proxies, on the wing source: parameters are the
inverse of evaluation, surfaces and curves lie where the sampler has its points; errors."""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import client, dimensions, failure, main, simple, update, values

VOLUME = simple.CatmullClarkToBSplineVolume(Input=simple.WingFuselageSource(Resolution=3))


def rows(array):
    return [array.GetTuple(n) for n in range(array.GetNumberOfTuples())]


def samples(block):
    sampler = simple.BSplineVolumeSampler(Input=VOLUME, Level=1, ComputeDerivatives=1)
    update(sampler)
    return sampler, client(sampler).GetOutputDataObject(0).GetPartition(block, 0)


def test_probe_finds_the_samples():
    # A block of the sampler as a source of points: parameters of its samples are halves.
    _sampler, grid = samples(7)
    source = simple.TrivialProducer()
    source.GetClientSideObject().SetOutput(grid)
    probe = simple.BSplineVolumeProbe(Input=VOLUME, Points=source, ComputeDerivatives=1)
    update(probe)
    output = client(probe).GetOutputDataObject(0)
    assert output.GetClassName() == "vtkStructuredGrid" and dimensions(output) == dimensions(grid)
    data = output.GetPointData()
    inside = client(probe).GetNumberOfPointsInside()
    assert inside == client(probe).GetNumberOfPoints() == grid.GetNumberOfPoints()
    blocks = values(data.GetArray("BlockId"))
    # Points on faces may belong to a neighbour of a lower number.
    assert max(blocks) == 7 and blocks.count(7) > len(blocks) / 2
    size = grid.GetLength()
    assert max(values(data.GetArray("Distance"))) <= 1e-12 * 50.0
    for n, (block, uvw) in enumerate(zip(blocks, rows(data.GetArray("UVW")))):
        if block == 7:
            assert all(abs(2.0 * x - round(2.0 * x)) <= 1e-6 for x in uvw), uvw
            inner = all(0.25 < x and abs(x - round(x)) > 0.25 for x in uvw)
            if inner:
                for name in ("dXdU", "dXdV", "dXdW"):
                    difference = [a - b for a, b in zip(data.GetArray(name).GetTuple(n),
                                                        grid.GetPointData().GetArray(name).GetTuple(n))]
                    assert max(map(abs, difference)) <= 1e-6 * size
    assert min(values(data.GetArray("Jacobian"))) > 0.0


def test_points_outside():
    line = simple.Line(Point1=[200.0, 0.0, 0.0], Point2=[300.0, 0.0, 0.0], Resolution=3)
    probe = simple.BSplineVolumeProbe(Input=VOLUME, Points=line)
    update(probe)
    assert client(probe).GetNumberOfPointsInside() == 0
    data = client(probe).GetOutputDataObject(0).GetPointData()
    assert values(data.GetArray("BlockId")) == [-1] * 4 and not data.HasArray("dXdU")
    assert client(probe).GetReport().startswith("0 of 4 points")


def test_surfaces_and_curves():
    _sampler, grid = samples(0)
    there = {tuple(grid.GetPoint(n)) for n in range(grid.GetNumberOfPoints())}
    size = dimensions(grid)
    for shape, direction, positions in ((0, 2, [0.0, 1.0]), (0, 0, [0.0]), (1, 1, [0.0, 1.0])):
        iso = simple.BSplineVolumeIsoparametric(Input=VOLUME, Shape=shape, Direction=direction, Positions=positions,
                                                Level=1)
        update(iso)
        data = client(iso).GetOutputDataObject(0)
        of_block = [n for n, block in enumerate(values(data.GetCellData().GetArray("BlockId"))) if block == 0]
        others = [size[d] - 1 for d in range(3) if d != direction]
        assert len(of_block) == (len(positions) * others[0] * others[1] if shape == 0 else len(positions) ** 2)
        # On faces and edges of the block they are the sampler's points, up to rounding.
        wanted = {point for cell in of_block for point in
                  [data.GetCell(cell).GetPointId(n) for n in range(data.GetCell(cell).GetNumberOfPoints())]}
        for n in wanted:
            x = data.GetPoint(n)
            assert min(max(abs(a - b) for a, b in zip(x, y)) for y in there) <= 1e-13 * 50.0, x


def test_errors():
    iso = simple.BSplineVolumeIsoparametric(Input=VOLUME, Positions=[0.5, 1.5])
    assert "1.5 is not between 0 and 1" in failure(iso)
    # What is missing is named, not a port of the pipeline.
    assert "Points: choose" in failure(simple.BSplineVolumeProbe(Input=VOLUME))
    assert "Before: choose" in failure(simple.BSplineVolumeDifference(Input=VOLUME))


if __name__ == "__main__":
    main(globals())
