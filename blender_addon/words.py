# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and tooltips of the filter's parameters as Blender has them.

The core's own texts are for the command line.
"""

# method: (name, tooltip), in the order of the menu; the first three are up front
METHODS = {
    "layered": (
        "Final",
        "Surfaces in layers that cover one another, as through a real lens. For final "
        "pictures",
    ),
    "box": (
        "Fast",
        "A square blur that takes the same time however large it is. To find the focus "
        "while you work",
    ),
    "views": (
        "Views",
        "Several renders from points of the lens, merged. Shows what near things hide "
        "from a single render",
    ),
    "accumulate": (
        "Accumulate",
        "The mean of many renders. Right for mirrors, glass and smoke too, but too few "
        "show as copies",
    ),
    "scatter": (
        "Scatter",
        "Each pixel is spread over its own circle. Colours of what is sharp may leak "
        "into the blur",
    ),
    "lowres": (
        "Low Resolution",
        "A small picture, magnified. The quickest, and coarse",
    ),
    "mipmap": ("Mipmap", "Smaller and smaller copies of the picture, magnified"),
    "offset": ("Offset", "Shifted copies of the picture, averaged"),
    "mipmap-offset": ("Mipmap Offset", "Four shifts of a smaller copy of the picture"),
    "recursive-offset": (
        "Recursive Offset",
        "The picture shifted and averaged again and again",
    ),
}
UP_FRONT = ("layered", "box", "views")

QUALITIES = {
    "preview": "At a fraction of the size, to find the focus",
    "normal": "Nearly as good as Best, in less time",
    "best": "For final pictures",
    "custom": "Set the options of the method by hand, under Advanced",
}

# field: (name, tooltip)
FIELDS = {
    "method": ("Method", "How the blur is made"),
    "quality": ("Quality", "How much time may go into the picture"),
    "supersample": (
        "Supersample",
        "Render at so many times the size, with as many fewer samples for each pixel: "
        "the same time for the renderer, and edges whose depth is known. The picture has "
        "the size that you ask for. 1: off. 0, automatic: 2 where Cycles takes no longer "
        "and the picture is better",
    ),
    "max_radius": ("Max Radius", "Largest radius of the blur, in pixels"),
    "coc_limit": (
        "Sharpness Limit",
        "Radius that still counts as sharp, for “Sharp from … to …” and for Focus",
    ),
    "film_depth": (
        "Film Depth",
        "Transparent film: which partly transparent pixels without a depth take that "
        "of the nearest surface",
    ),
    "sub_apertures": (
        "Sub-Apertures",
        "Parts of the lens whose view is kept apart. More is more exact behind edges",
    ),
    "split_edges": (
        "Split Edges",
        "Divide the smooth pixels of edges into their two surfaces",
    ),
    "fill_hidden": (
        "Fill Hidden",
        "Estimate what a single render could not see behind near things",
    ),
    "exact_highlights": (
        "Exact Highlights",
        "Follow what cuts into the bokeh of each highlight",
    ),
    "distribution": ("Distribution", "How a circle of confusion shares out the light"),
    "blend_gamma": (
        "Gamma",
        "Gamma of the space in which light is summed. 1 is physically right",
    ),
    "blend": ("Blend", "How the blurred and the sharp picture are put together"),
    "blur_radius": (
        "Blur Radius",
        "Radius of the most blurred copy, in pixels. Automatic is that of what lies "
        "infinitely far",
    ),
    "box_repeats": (
        "Repeats",
        "How often the square blur is repeated. 1 is a square, 3 is nearly round",
    ),
    "lowres_factor": ("Shrink", "How much smaller the small picture is"),
    "mipmap_bias": ("Bias", "Added to the level of detail. More blurs more"),
    "copies": ("Copies", "How many shifted copies are averaged"),
    "recursions": ("Recursions", "How often the picture is shifted and averaged"),
    "region_size": (
        "Region Size",
        "Depth before and behind the focus that stays sharp. Automatic is the depth of "
        "field",
    ),
    "region_slope": (
        "Region Slope",
        "How fast the blur sets in outside of the region, per unit of length. Automatic "
        "follows the focus distance",
    ),
    "stage": (
        "Stage",
        "Shows a step on the way in place of the picture. For lessons",
    ),
    "box_direction": ("Direction", "Along which side of the picture it blurs"),
    "slices": ("Slices", "Planes on either side of the focus"),
    "leak_control": ("Leak Control", "What keeps sharp colours out of the blur"),
    "leak_weight": (
        "Leak Weight",
        "Weight of the product of the blurred masks against their mean",
    ),
    "leave_focus_out": (
        "Leave Focus Out",
        "Leave what is in focus out of the blurred copy",
    ),
    "lens_pattern": ("Lens Pattern", "Where on the lens the views are taken"),
    "lens_random": ("Lens Random", "Take other points of the lens in every frame"),
    "lens_seed": ("Lens Seed", "Start of the random numbers"),
    "blade_curvature": (
        "Blade Curvature",
        "How round the blades' edges are: 0 straight, 1 the circle through the corners, "
        "below 0 hollow",
    ),
    "cat_eye": (
        "Cat's Eyes",
        "Discs become lemons towards the corners, as in a lens whose barrel cuts in",
    ),
    "cat_eye_exposure": (
        "Corners",
        "What the light that Cat's Eyes and Barn Doors take does to the picture",
    ),
    "astigmatism": (
        "Astigmatism",
        "Discs grow towards the corners, along the line from the centre",
    ),
    "swirl": (
        "Swirl",
        "Discs grow towards the corners, around the centre, as in old portrait lenses",
    ),
    "barn_left": ("Barn Door Left", "Discs are cut straight at the left"),
    "barn_right": ("Barn Door Right", "Discs are cut straight at the right"),
    "barn_top": ("Barn Door Top", "Discs are cut straight at the top"),
    "barn_bottom": ("Barn Door Bottom", "Discs are cut straight at the bottom"),
    "spherical": (
        "Spherical",
        "What the rim of the lens takes off the blur. Above 0, discs behind the focus "
        "have bright rims; below, soft ones",
    ),
    "axial_chroma": (
        "Axial Colour",
        "Red is blurred so much more and blue less: coloured rims",
    ),
    "lateral_chroma": (
        "Lateral Colour",
        "Red is magnified and blue made smaller: fringes towards the corners",
    ),
    "obstruction": (
        "Mirror",
        "How much of the middle of the aperture is hidden, as in mirror lenses: discs "
        "become rings",
    ),
    "highlight_clamp": (
        "Highlight Clamp",
        "Light that a pixel may have at most before it is blurred: a firefly would "
        "become a bright disc. Lamps in the picture lose light too",
    ),
    "highlight_threshold": (
        "Highlight Threshold",
        "Light above which a pixel is a highlight",
    ),
    "highlight_gain": (
        "Highlight Gain",
        "What is above the threshold is multiplied by this before it is blurred. More "
        "makes the bokeh brighter",
    ),
    "highlight_saturation": (
        "Highlight Saturation",
        "Saturation of what is above the threshold. Its luminance stays",
    ),
    "tilt_x": (
        "Tilt X",
        "Tilts the lens: what is in focus comes nearer at the right (Scheimpflug)",
    ),
    "tilt_y": (
        "Tilt Y",
        "Tilts the lens: what is in focus comes nearer at the top. For miniatures",
    ),
    "field_curvature": (
        "Field Curvature",
        "Bends what is in focus: above 0 it comes nearer towards the corners",
    ),
    "split_diopter": (
        "Split Diopter",
        "A second focus distance on one side of the picture; 0 for none",
    ),
    "split_angle": (
        "Split Angle",
        "Where the side of the second focus lies: 0° is the right, 90° the top",
    ),
    "split_offset": (
        "Split Offset",
        "How far from the middle the side of the second focus begins, in halves of the "
        "diagonal",
    ),
    "split_softness": (
        "Split Softness",
        "Width of the border between the two focus distances",
    ),
}

# (field, choice): tooltip
CHOICES = {
    ("film_depth", "keep"): "As rendered: infinitely far",
    ("film_depth", "solid"): "Where alpha is above 0.5, 2 px from a surface",
    ("film_depth", "all"): "Wherever there is something, 2 px from a surface",
    ("film_depth", "edges"): "Between a surface and what is empty: rims, soft ones too",
    ("distribution", "uniform"): "Equal light over the circle",
    ("distribution", "gaussian"): "Soft, bright in the middle",
    ("distribution", "ring"): "A bright rim, as of a mirror lens",
    ("distribution", "image"): "A picture of the aperture, chosen below",
    ("blend", "coc"): "Each pixel is blurred by its own circle of confusion",
    ("blend", "region"): "Sharp around the focus, a ramp outside",
    ("blend", "slices"): "Planes on both sides of the focus, back to front",
    ("stage", "result"): "The filtered picture",
    ("stage", "levels"): "The levels of detail of Mipmap and Mipmap Offset",
    ("stage", "alpha"): "How much of the blurred picture is taken",
    ("stage", "slices"): "The same with a colour for each slice",
    ("box_direction", "both"): "Along rows, then along columns",
    ("box_direction", "horizontal"): "Along rows alone, as something that moves",
    ("box_direction", "vertical"): "Along columns alone",
    ("leak_control", "none"): "Colours leak",
    ("leak_control", "product"): "Mean and product of four blurred masks",
    ("leak_control", "hint"): "The blurred mask",
    ("cat_eye_exposure", "fall"): "They grow darker, as behind the lens itself",
    ("cat_eye_exposure", "keep"): "They keep their light: only the shape changes",
    ("lens_pattern", "auto"): "Polygon where the camera has blades, else disc",
    ("lens_pattern", "disc"): "Spread evenly over the disc",
    ("lens_pattern", "circle"): "Evenly along the rim",
    ("lens_pattern", "polygon"): "Spread evenly over the polygon of the blades",
    ("lens_pattern", "grid"): "One point at a random place of each of equal cells",
}

# fields whose 0 means that the filter chooses, or none: what a click on the tick starts with
AUTOMATIC = {
    "supersample": 2,
    "max_radius": 64.0,
    "blur_radius": 16.0,
    "region_size": 1.0,
    "region_slope": 1.0,
    "highlight_clamp": 10.0,
}
# those of them whose 0 means none
OFF = {"highlight_clamp": "Off: the light of pixels has no limit"}


def title(name):
    """A field's or choice's name for the interface where none is given here."""
    return name.replace("_", " ").replace("-", " ").title()
