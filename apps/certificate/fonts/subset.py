#!/usr/bin/env python3
"""Cuts the mathematics font down to what formulas of certificates use, and gives it another name, as its licence asks.

    subset.py NewCMMath-Book.otf ProofmassMath.otf      needs fonttools
"""

import sys

from fontTools import subset
from fontTools.ttLib import TTFont

CHARACTERS = [
    (0x20, 0x7E), (0xA0, 0xFF), (0x131, 0x131), (0x237, 0x237),  # Latin
    (0x300, 0x30C), (0x338, 0x338), (0x20D6, 0x20D7), (0x20DB, 0x20DC),  # accents
    (0x391, 0x3A9), (0x3B1, 0x3D6), (0x3F0, 0x3F5),  # Greek
    (0x2009, 0x2016), (0x2020, 0x2022), (0x2026, 0x2026), (0x2032, 0x2037), (0x2044, 0x2044), (0x2061, 0x2064),
    (0x2102, 0x2102), (0x210E, 0x2113), (0x211C, 0x211D), (0x2111, 0x2111), (0x2126, 0x2126), (0x212B, 0x212B),
    (0x2190, 0x2195), (0x21A6, 0x21A6), (0x21D0, 0x21D5),  # arrows
    (0x2200, 0x222E), (0x2236, 0x2237), (0x223C, 0x223D), (0x2243, 0x2248), (0x2254, 0x2255), (0x225C, 0x225D),
    (0x2260, 0x2269), (0x226A, 0x226B), (0x2282, 0x2287), (0x2295, 0x2299), (0x22A4, 0x22A5), (0x22C0, 0x22C3),
    (0x22C5, 0x22C6), (0x22EE, 0x22F1),  # operators
    (0x2308, 0x230B), (0x23B0, 0x23B1), (0x23DC, 0x23E1), (0x27E8, 0x27EB), (0x27F5, 0x27F7),  # brackets, long arrows
    (0x2A7D, 0x2A7E),
    (0x1D400, 0x1D467), (0x1D6A4, 0x1D6A5), (0x1D6A8, 0x1D755), (0x1D7CE, 0x1D7D7),  # bold, italic
]

source, target = sys.argv[1:]
options = subset.Options(
    layout_features=["*"], notdef_outline=True, hinting=False, desubroutinize=False, name_IDs=["*"],
    drop_tables=["FFTM", "PfEd", "DSIG"], recalc_timestamp=False,
)
font = subset.load_font(source, options)
subsetter = subset.Subsetter(options)
subsetter.populate(unicodes=[c for first, last in CHARACTERS for c in range(first, last + 1)])
subsetter.subset(font)
for record in font["name"].names:
    if record.nameID in (1, 3, 4, 6, 16):
        record.string = "ProofmassMath" if record.nameID in (3, 6) else "Proofmass Math"
top = font["CFF "].cff
top.fontNames = ["ProofmassMath"]
top.topDictIndex[0].FamilyName = top.topDictIndex[0].FullName = "Proofmass Math"
subset.save_font(font, target, options)
