# SPDX-License-Identifier: BSD-3-Clause
"""A name that chooses nothing is said, with the names that there are: every property of every filter that takes names."""
import glob
import os
import sys
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from bsv_support import ROOT, simple, client, main, messages

WING = simple.WingFuselageSource(Resolution=2)
VOLUME = simple.CatmullClarkToBSplineVolume(Input=WING, Body=simple.OutputPort(WING, 1))
ABSENT = "no such name"


def named_properties():
    """Filter, property, strings per entry, and whether its input is a volume, of all lists of names in the XML."""
    found = []
    for file in sorted(glob.glob(os.path.join(ROOT, "Plugin", "*.xml"))):
        for proxy in ElementTree.parse(file).iter("SourceProxy"):
            fields = [domain.get("present") for domain in proxy.iter("FieldArrayDomain")]
            for prop in proxy.iter("StringVectorProperty"):
                if prop.get("repeat_command") == "1" and not prop.get("si_class") and \
                        prop.get("information_only") != "1" and prop.find("FileListDomain") is None:
                    found.append((proxy.get("name"), prop.get("name"),
                                  int(prop.get("number_of_elements_per_command", 1)), "KnotsW" in fields))
    return found


def said(name, prop, width, of_volume):
    """Errors and warnings of the filter with one more name."""
    proxy = getattr(simple, name)(Input=VOLUME if of_volume else WING)
    names = list(proxy.GetPropertyValue(prop))
    entry = [ABSENT] if width == 1 else [ABSENT, "0.5"]
    proxy.SetPropertyWithName(prop, names + entry)
    with messages(proxy) as caught:
        proxy.UpdatePipeline()
    simple.Delete(proxy)
    return caught


def test_names_that_choose_nothing():
    properties = named_properties()
    assert len(properties) >= 11, properties
    WING.UpdatePipeline()
    fields = client(WING).GetOutputDataObject(0).GetFieldData()
    boundary = fields.GetAbstractArray("BoundaryNames").GetValue(0)
    for name, prop, width, of_volume in properties:
        caught = said(name, prop, width, of_volume)
        texts = [text for text in caught["errors"] + caught["warnings"] if ABSENT in text]
        assert len(texts) == 1, (name, prop, caught)
        label = "".join(" " + c if c.isupper() else c for c in prop).strip()
        assert label in texts[0], (label, texts)
        # Blocks may be thousands: then the first name stands for all.
        assert "'%s'" % boundary in texts[0] or "the first one is '" in texts[0], texts


if __name__ == "__main__":
    main(globals())
