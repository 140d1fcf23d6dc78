"""Colours of the drawn crawler, 0 to 255, which figures and films share with it."""

Colour = tuple[int, int, int]

# ColorBrewer's RdBu, from blue to red: safe for colour-blind readers. Stretched, at rest, contracted.
CONTRACTION_SCALE: tuple[Colour, ...] = (
    (5, 48, 97), (33, 102, 172), (67, 147, 195), (146, 197, 222), (209, 229, 240), (247, 247, 247),
    (253, 219, 199), (244, 165, 130), (214, 96, 77), (178, 24, 43), (103, 0, 31),
)  # fmt: skip
CONTRACTION_LIMIT = 0.4  # strain at the ends of the scale

WHITE: Colour = (255, 255, 255)
INK: Colour = (51, 51, 51)
SKIN: Colour = (240, 226, 200)
EARTH: Colour = (224, 215, 198)
EARTH_INK: Colour = (122, 108, 84)
