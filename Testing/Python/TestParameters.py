# SPDX-License-Identifier: BSD-3-Clause
"""Ranks compare the properties of an algorithm by what it prints: so every property of the panel is printed, with all
digits that matter, and nothing that differs between two equal objects or from run to run."""
import glob
import os
import re
import sys
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bsplinevolume
from bsplinevolume.pipeline import set_properties, words_of
from bsv_support import ROOT, main, vtk


def proxies():
    """Class and element of every algorithm in the XML."""
    for file in sorted(glob.glob(os.path.join(ROOT, "Plugin", "*.xml"))):
        for proxy in ElementTree.parse(file).iter():
            if proxy.tag in ("SourceProxy", "WriterProxy") and proxy.get("class"):
                yield proxy.get("class"), proxy


def own_text(algorithm):
    """What the class adds to what VTK prints of all objects."""
    common = {line.split(":")[0].strip() for line in str(vtk.vtkTrivialProducer()).splitlines()[1:]}
    return [line for line in str(algorithm).splitlines()[1:] if line.split(":")[0].strip() not in common]


def arguments(prop):
    """Arguments of the setter, the default ones not alone among them."""
    kind = prop.tag[:-len("VectorProperty")]
    width = int(prop.get("number_of_elements_per_command") or prop.get("number_of_elements") or 1)
    if prop.get("use_index") == "1":
        return [[0, 0.4375]]
    defaults = (prop.get("default_values") or "").split()
    if kind == "String":
        types = (prop.get("element_types") or "2").split()
        return [["other" if types[n % len(types)] == "2" else 0 for n in range(width)]]
    if kind == "Double":
        return [[0.4375] * width]
    entries = [[int(entry.get("value"))] for entry in prop.iter("Entry")]
    if entries:
        return entries
    if prop.find("BooleanDomain") is not None:
        return [[0], [1]]
    default = int(float(defaults[0])) if defaults else 0
    return [[default + 1] * width, [default - 1] * width]


def test_every_property_is_printed():
    found = 0
    for name, proxy in proxies():
        for prop in proxy:
            if not prop.tag.endswith("VectorProperty") or prop.get("information_only") == "1" or \
                    prop.get("si_class") or not prop.get("command"):
                continue
            algorithm = getattr(bsplinevolume, name)()
            if prop.get("set_number_command"):
                getattr(algorithm, prop.get("set_number_command"))(1)
            texts = {tuple(own_text(algorithm))}
            for values in arguments(prop):
                try:
                    getattr(algorithm, prop.get("command"))(*values)
                except TypeError:
                    getattr(algorithm, prop.get("command"))(values[0], 0.4375)
                texts.add(tuple(own_text(algorithm)))
            assert len(texts) > 1, (name, prop.get("name"), texts)
            found += 1
    print("%d properties" % found)
    assert found > 100


def test_numbers_that_are_not_finite_are_refused():
    found = 0
    for name, proxy in proxies():
        for prop in proxy:
            if prop.tag != "DoubleVectorProperty" or prop.get("information_only") == "1" or proxy.tag == "WriterProxy":
                continue
            # Properties with a least value drop what is no number, or take that value.
            for value in (float("nan"), float("inf")):
                algorithm = getattr(bsplinevolume, name)()
                if prop.get("set_number_command"):
                    getattr(algorithm, prop.get("set_number_command"))(1)
                values = [0] * (prop.get("use_index") == "1") + [value] * int(
                    prop.get("number_of_elements_per_command") or prop.get("number_of_elements") or 1)
                try:
                    getattr(algorithm, prop.get("command"))(*values)
                except TypeError:
                    getattr(algorithm, prop.get("command"))("wall", value)
                errors = []
                def keep(_caller, _event, text):
                    errors.append(text)
                keep.CallDataType = vtk.VTK_STRING
                algorithm.AddObserver("ErrorEvent", keep)
                printed = any("nan" in line or "inf" in line for line in own_text(algorithm))
                algorithm.Update()
                if printed:
                    assert len(errors) == 1 and "is no finite number" in errors[0], (name, prop.get("name"), errors)
                    found += 1
    print("%d refusals" % found)
    assert found > 40


def test_equal_objects_print_the_same():
    for name in sorted({name for name, _ in proxies()}):
        cls = getattr(bsplinevolume, name)
        first, second = own_text(cls()), own_text(cls())
        assert first == second, (name, first, second)
        assert not any("0x" in line for line in first), (name, first)


def test_words_are_those_of_the_panel():
    """One word per thing: what ParaView shows of an enumeration is what Python and the command take."""
    found = 0
    for name, proxy in proxies():
        for prop in proxy:
            entries = {re.sub(r"\W", "", entry.get("text")).lower(): int(entry.get("value"))
                       for entry in prop.iter("Entry")}
            if entries:
                algorithm = getattr(bsplinevolume, name)()
                words = {word.lower(): number for word, number in words_of(algorithm, prop.get("name")).items()}
                assert entries.items() <= words.items(), (name, prop.get("name"), entries, words)
                assert set(entries.values()) == set(words.values()), (name, prop.get("name"), entries, words)
                for entry in prop.iter("Entry"):
                    set_properties(algorithm, {prop.get("name"): entry.get("text")})
                    assert getattr(algorithm, "Get" + prop.get("name"))() == int(entry.get("value"))
                found += 1
    assert found > 15


def test_old_words():
    for name, prop, word, number in (("vtkHexBlockMeshReader", "IBlank", "WithoutIblank", 1),
                                     ("vtkQuadflowWriter", "KnotScaling", "UnitKnots", 1)):
        algorithm = getattr(bsplinevolume, name)()
        set_properties(algorithm, {prop: word})
        assert getattr(algorithm, "Get" + prop)() == number


if __name__ == "__main__":
    main(globals())
