# SPDX-License-Identifier: Apache-2.0
# Made by plugin/make_types.py of core/include/rackfocus/params.def; not by hand.
"""The keywords of the parameters, for type checkers."""

from typing import Any, Literal, TypedDict


class Parameters(TypedDict, total=False):
    focus_distance: float
    f_stop: float
    focal_length: float
    sensor_width: float
    sensor_height: float
    sensor_fit: Literal["auto", "horizontal", "vertical"]
    unit_scale: float
    lens_radius: float
    focal_length_px: float
    projection: Literal["perspective", "orthographic"]
    ortho_scale: float
    shift_x: float
    shift_y: float
    pixel_aspect: float
    optics: Literal["camera", "lens", "yu", "buffer"]
    screen_position: float
    aperture_coefficient: float
    coc_limit: float
    aperture: Literal["auto", "disc", "polygon", "image"]
    blades: int
    blade_rotation: float
    blade_orientation: Literal["cycles", "povray"]
    aperture_ratio: float
    depth: Literal[
        "planar",
        "radial",
        "buffer",
        "buffer-reversed",
        "buffer-infinite",
        "buffer-reversed-infinite",
        "inverse",
        "disparity",
        "normalised",
    ]
    depth_near: float
    depth_far: float
    depth_scale: float
    depth_offset: float
    depth_infinity: float
    film_depth: Literal["keep", "solid", "all", "edges"]
    method: Literal[
        "layered",
        "scatter",
        "box",
        "lowres",
        "mipmap",
        "offset",
        "mipmap-offset",
        "recursive-offset",
        "views",
        "accumulate",
    ]
    max_radius: float
    sub_apertures: int
    split_edges: bool
    fill_hidden: bool
    exact_highlights: bool
    distribution: Literal["uniform", "gaussian", "ring", "image"]
    blend_gamma: float
    blend: Literal["coc", "region", "slices"]
    blur_radius: float
    box_repeats: int
    lowres_factor: int
    mipmap_bias: float
    copies: int
    recursions: int
    region_size: float
    region_slope: float
    slices: int
    leak_control: Literal["none", "product", "hint"]
    leak_weight: float
    leave_focus_out: bool
    lens_pattern: Literal["auto", "disc", "circle", "polygon", "grid"]
    lens_random: bool
    lens_seed: int
    quality: Literal["preview", "normal", "best"]
    blade_curvature: float
    cat_eye: float
    cat_eye_exposure: Literal["fall", "keep"]
    astigmatism: float
    swirl: float
    barn_left: float
    barn_right: float
    barn_top: float
    barn_bottom: float
    tilt_x: float
    tilt_y: float
    field_curvature: float
    split_diopter: float
    split_angle: float
    split_offset: float
    split_softness: float
    spherical: float
    axial_chroma: float
    lateral_chroma: float
    obstruction: float
    highlight_clamp: float
    highlight_threshold: float
    highlight_gain: float
    highlight_saturation: float
    stage: Literal["result", "levels", "alpha", "slices"]
    box_direction: Literal["both", "horizontal", "vertical"]
    white: float


class FilterParameters(Parameters, total=False):
    distribution_image: Any
