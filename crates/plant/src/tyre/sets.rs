//! Parameter sets that ship, by the name of their publication.

use super::{
    Combined, Friction, LateralForm, LinearTyre, MagicFormula, MagicFormula1989, NoSlip, Tyre,
    Vertical,
};

/// A parameter set with its name and origin.
#[derive(Clone, Copy, Debug)]
pub struct TyreSet {
    /// Name, for TOML and command line.
    pub name: &'static str,
    /// What it is and where it comes from.
    pub about: &'static str,
    /// The tyre.
    pub tyre: Tyre,
}

/// The set called `name`; the name of a registry entry gives its first set.
pub fn set(name: &str) -> Option<&'static TyreSet> {
    SETS.iter()
        .find(|set| set.name == name)
        .or_else(|| SETS.iter().find(|set| set.tyre.name() == name))
}

/// Vertical spring and damper of Bulsink (2017), table A.1.
const BULSINK_VERTICAL: Vertical = Vertical {
    stiffness_n_m: 108_970.0,
    damping_n_s_m: 5_448.0,
};

/// Bulsink (2017), table A3: tyre 2 (37-622), 4 bar, 400 N.
const BULSINK_400N: MagicFormula = MagicFormula {
    nominal_load_n: 400.0,
    longitudinal_shape_ratio: 1.0,
    longitudinal_friction_ratio: 1.642,
    longitudinal_stiffness_ratio: 12.0,
    slip_shape_ratio: 0.990,
    camber_shape_ratio: 1.0,
    lateral_friction_ratio: 1.642,
    lateral_friction_load_ratio: -0.017,
    cornering_max_per_rad: -16.07,
    cornering_peak_ratio: 1.011,
    camber_stiffness_per_rad: -1.444,
    camber_stiffness_load_per_rad: -0.510,
    trail_slope_per_rad: 73.49,
    trail_slope_load_per_rad: -87.36,
    trail_shape_ratio: 1.0,
    trail_peak_ratio: 0.054,
    trail_peak_load_ratio: -0.043,
    twisting_per_rad: -0.134,
    twisting_load_per_rad: 0.084,
    rolling_resistance_ratio: 0.008,
    overturning_ratio: 0.053,
    longitudinal_gain: 1.0,
    cornering_gain: 1.0,
    camber_gain: 1.0,
    trail_gain: 1.0,
    twisting_gain: 1.0,
    overturning_gain: 1.0,
    friction: Friction::AsFile,
    combined: Combined::None,
    lateral_form: LateralForm::Motorcycle,
    frozen_load_n: None,
    load_range_n: None,
    vertical: BULSINK_VERTICAL,
    relaxation_length_m: None,
};

/// Slopes of [`BULSINK_400N`] at the origin at 400 N and a wheel radius of 0.35 m.
const BULSINK_LINEAR: LinearTyre = LinearTyre {
    nominal_load_n: 400.0,
    longitudinal_stiffness_ratio: 12.0,
    // 16.07 sin(atan(1 / 1.011)) = 16.07 / √(1 + 1.011²)
    cornering_stiffness_per_rad: 11.300_881_137_804,
    camber_stiffness_per_rad: 1.444,
    // 0.35 m x 0.054
    pneumatic_trail_m: 0.0189,
    // 0.35 m x 0.134
    twisting_m_per_rad: 0.0469,
    // 0.35 m x 0.053
    crown_radius_m: 0.01855,
    rolling_resistance_ratio: 0.008,
    vertical: BULSINK_VERTICAL,
    relaxation_length_m: None,
};

/// Schwalbe Energizer Plus 28x1.75 at one pressure. Longitudinal slip and rolling resistance are
/// those of Bulsink (2017); the crown radius is half the tyre's 47 mm over a wheel radius of
/// 0.35 m; the vertical spring is that of Bulsink (2017), of a narrower tyre.
const fn schwalbe_t03(side_force: [f64; 14], aligning: [f64; 18]) -> Tyre {
    Tyre::MagicFormula1989(MagicFormula1989 {
        nominal_load_n: 400.0,
        side_force,
        aligning,
        remove_offsets: true,
        slip_angle_limit_rad: core::f64::consts::PI / 18.0,
        camber_limit_rad: core::f64::consts::FRAC_PI_6,
        load_range_n: [200.0, 1000.0],
        longitudinal_stiffness_ratio: 12.0,
        longitudinal_friction_ratio: 1.0,
        rolling_resistance_ratio: 0.008,
        overturning_ratio: 0.067,
        longitudinal_gain: 1.0,
        cornering_gain: 1.0,
        camber_gain: 1.0,
        trail_gain: 1.0,
        twisting_gain: 1.0,
        overturning_gain: 1.0,
        friction: Friction::AsFile,
        combined: Combined::Ellipse,
        vertical: BULSINK_VERTICAL,
        relaxation_length_m: None,
    })
}

const SCHWALBE_T03_300KPA: Tyre = schwalbe_t03(
    [
        3.11785071938867,
        -752.571579481671,
        1187.6971313973,
        124.4775039721,
        0.760139546489959,
        0.000517867267912517,
        -0.019028353643261,
        1.48507598866898,
        0.0311484079416778,
        0.0992266045584514,
        -0.0820737048903585,
        7.30337892653729,
        -22.5925899864901,
        5.37222617956484,
    ],
    [
        2.09906592639809,
        10.5876618219117,
        2.60441934159322,
        0.0623247274902716,
        -3.31585328999185,
        -0.758382115661707,
        -0.00823334974409863,
        5.98641545944234,
        -4.75600872857059,
        -0.99509757625686,
        0.0280636613550883,
        0.0706921463627212,
        0.228420786641289,
        -0.17813488285145,
        -0.0205023109359104,
        0.332376760298719,
        0.233694325855722,
        -0.0113037558378034,
    ],
);

const SCHWALBE_T03_400KPA: Tyre = schwalbe_t03(
    [
        2.4168758341421,
        -827.13747376476,
        1237.66083004943,
        395.200360397803,
        3.0446816178572,
        0.00261138053320087,
        -0.922053239766776,
        1.64994486504353,
        0.0379083581395092,
        0.736968117242096,
        -0.266395254094883,
        5.5067068363462,
        -128.33228607201,
        42.3694891796893,
    ],
    [
        2.21843255129583,
        11.5353268949534,
        0.999589243739601,
        -0.421820285221245,
        -4.40274539041674,
        0.18952433339822,
        0.0052967747005171,
        7.1844346628074,
        -16.9117717254093,
        5.14613592375553,
        -0.126298815430486,
        0.0745699176433646,
        -1.21219459523314,
        0.453513932334205,
        0.602307673841529,
        0.0536303220687809,
        -0.656371696645942,
        0.407297064320888,
    ],
);

const SCHWALBE_T03_500KPA: Tyre = schwalbe_t03(
    [
        2.82190142692177,
        -600.725093731511,
        1126.13419486956,
        108.195059542367,
        0.683427366605219,
        0.00101429526187314,
        -0.885759309085851,
        1.73048558338238,
        0.0486094399802349,
        0.66262538419806,
        -0.175004229143779,
        3.48488836431515,
        59.7995288076727,
        -24.3588719849742,
    ],
    [
        2.2328829887519,
        5.6439542000348,
        2.85799096871478,
        -16.6499069948331,
        -0.436719975133473,
        1.76980762416801,
        0.0184170389395877,
        -53.2158085410518,
        53.5007295689835,
        -16.1916676969663,
        -0.0098780637409612,
        0.109973767496453,
        -0.0224995998383167,
        0.0595781833578477,
        0.652621022173824,
        0.0958581116776279,
        0.0163525377116817,
        0.0162591874180916,
    ],
);

/// Every set that ships. The first of each model answers to the model's name.
pub const SETS: &[TyreSet] = &[
    TyreSet {
        name: "bulsink2017",
        about: "Bulsink 2017, table A3: tyre 2 (37-622) at 4 bar; coefficients follow load",
        tyre: Tyre::MagicFormula(BULSINK_400N),
    },
    TyreSet {
        name: "bulsink2017_400n",
        about: "table A3 as measured at 400 N, whatever the load",
        tyre: Tyre::MagicFormula(MagicFormula {
            frozen_load_n: Some(400.0),
            ..BULSINK_400N
        }),
    },
    TyreSet {
        name: "bulsink2017_600n",
        about: "table A3 with its load dependence taken to 600 N, whatever the load; the \
                coefficients measured at 600 N themselves are not published",
        tyre: Tyre::MagicFormula(MagicFormula {
            frozen_load_n: Some(600.0),
            ..BULSINK_400N
        }),
    },
    TyreSet {
        name: "bulsink2017_ellipse",
        about: "table A3 with the road's friction as the limit and the friction ellipse",
        tyre: Tyre::MagicFormula(MagicFormula {
            friction: Friction::Absolute,
            combined: Combined::Ellipse,
            ..BULSINK_400N
        }),
    },
    TyreSet {
        name: "bulsink2017_linear",
        about: "slopes of table A3 at 400 N, wheel radius 0.35 m",
        tyre: Tyre::Linear(BULSINK_LINEAR),
    },
    TyreSet {
        name: "schwalbe_t03_400kpa",
        about: "Schwalbe Energizer Plus 28x1.75 at 400 kPa, VeTyT rig, offsets removed",
        tyre: SCHWALBE_T03_400KPA,
    },
    TyreSet {
        name: "schwalbe_t03_300kpa",
        about: "Schwalbe Energizer Plus 28x1.75 at 300 kPa, VeTyT rig, offsets removed",
        tyre: SCHWALBE_T03_300KPA,
    },
    TyreSet {
        name: "schwalbe_t03_500kpa",
        about: "Schwalbe Energizer Plus 28x1.75 at 500 kPa, VeTyT rig, offsets removed",
        tyre: SCHWALBE_T03_500KPA,
    },
    TyreSet {
        name: "no_slip",
        about: "rolls without slip, by constraint",
        tyre: Tyre::NoSlip(NoSlip {}),
    },
];
