"""The table of gaits: one row is one motion. A new style is a new row; `Gait` says what the entries mean.

Lengths in frames are those of the paper's reference motions (Table 1), and so are the words that the rows follow.
"""

from adapt_envs.motion.synthesis.gait import Arm, Gait, Kick, Wave

_AKIMBO = Arm(flexion=Wave(-6), outward=Wave(42), twist=Wave(68), elbow=Wave(101))
"""Hand on the hip, elbow out."""

_BASES = (
    Gait("Walk", kind="walk"),
    Gait(
        "Run",
        kind="run",
        width=0.09,
        double=-0.3,
        toe_out=4,
        strike=(4, 4),
        push=(44, 44),
        rise=0.55,
        roll=(0.05, 0.13),
        clearance=0.03,
        outward=0.03,
        braking=50.0,
        kick=((Kick(-0.12, 0.18, 16, peak=0.34, sharpness=2.2), Kick(0.0, 0.05, peak=0.68, sharpness=1.2)),) * 2,
        pelvis_yaw=Wave(0, 8, 10),
        pelvis_list=Wave(0, -4, 75),
        pelvis_tilt=Wave(7),
        torso_pitch=Wave(7, 0, 0, 1.5, 60),
        torso_yaw=Wave(0, -9, 5),
        head_pitch=Wave(4),
        arms=(Arm(Wave(0, -32, 0), Wave(12), Wave(18), Wave(85, -12, 0)),) * 2,
    ),
)

_STYLES = (
    Gait(  # exaggerated walking with one arm akimbo
        "Swaggering", frames=32, length=(0.64, 0.64), width=0.11, knee_out=6, toe_out=10,
        pelvis_yaw=Wave(0, 9, 10), pelvis_list=Wave(0, -6, 75),
        torso_yaw=Wave(0, -9, 10), torso_roll=Wave(0, 6, 80), torso_pitch=Wave(-5, 0, 0, 1.5, 60),
        head_roll=Wave(0, 3, 80), head_pitch=Wave(-5),
        arms=(Arm(Wave(8, -34, 15), Wave(14), Wave(15), Wave(32, -18, 30)), _AKIMBO),
    ),
    Gait(  # goose step with arms akimbo
        "GooseStep", kind="forceful", frames=66, length=(0.62, 0.62), double=0.2, toe_out=4,
        strike=(2, 2), push=(38, 38), clearance=0.03, outward=0.02, surge=0.3, bob=0.065, rise=0.85,
        kick=((Kick(0.48, 0.0, -42, peak=0.54), Kick(0.0, 0.52, stretch=1, peak=0.57, sharpness=3.5)),) * 2,
        pelvis_tilt=Wave(-2, 0, 0, 3, 200), pelvis_yaw=Wave(0, 4, 10), pelvis_list=Wave(0, -2, 75),
        torso_pitch=Wave(-2, 0, 0, 2, 200), torso_yaw=Wave(0, -2, 10), head_pitch=Wave(-3),
        arms=(_AKIMBO, _AKIMBO),
    ),
    Gait(  # walking while stomping on the ground
        "Stomp", kind="forceful", frames=37, length=(0.50, 0.50), width=0.17, double=0.16, toe_out=10,
        strike=(-2, -2), push=(35, 35), rise=0.7, clearance=0.03, crouch=0.025, bob=0.075, surge=0.45,
        kick=((Kick(0.04, 0.25, peak=0.62),), (Kick(0.04, 0.25, peak=0.62),)),
        torso_pitch=Wave(9, 0, 0, 4, 20), torso_roll=Wave(0, 5, 60), torso_yaw=Wave(0, -8, 10), head_pitch=Wave(12),
        arms=(Arm(Wave(10, -24, 0), Wave(20), Wave(20), Wave(65, -12, 0)),) * 2,
    ),
    Gait(  # walking with leg kicking
        "Kicking", kind="forceful", frames=61, length=(0.62, 0.62), double=0.2, strike=(8, 8), push=(45, 45),
        clearance=0.03, surge=0.3, bob=0.06, rise=0.85,
        kick=((Kick(-0.06, 0.14, 20, peak=0.34, sharpness=3.5), Kick(0.46, 0.40, -42, 1, 0.56, 4.2)),) * 2,
        pelvis_tilt=Wave(0, 0, 0, 4, 200), pelvis_yaw=Wave(0, 7, 10),
        torso_pitch=Wave(-1, 0, 0, 5, 200), torso_yaw=Wave(0, -9, 10),
        arms=(Arm(Wave(10, -30, 0), Wave(16), Wave(10), Wave(45, -15, 0)),) * 2,
    ),
    Gait(  # slow walking with body bent over
        "Stoop", frames=28, length=(0.43, 0.43), width=0.13, strike=(10, 10), push=(38, 38), crouch=0.05, bob=0.02,
        pelvis_tilt=Wave(20), pelvis_yaw=Wave(0, 5, 10),
        torso_pitch=Wave(54, 0, 0, 1.5, 60), torso_yaw=Wave(0, -5, 10), head_pitch=Wave(22),
        arms=(Arm(Wave(44, -13, 15), Wave(6), Wave(5), Wave(18, -6, 30)),) * 2,
    ),
    Gait(  # skipping in a spirited manner
        "JauntySkip", kind="hopping", frames=48, length=(1.0, 1.0), hop=(0.45, 0.70), double=0.08, width=0.08,
        toe_out=4, strike=(2, 2), push=(44, 44), rise=0.6, roll=(0.03, 0.125), clearance=0.035, bob=0.03, outward=0.01,
        kick=((Kick(0.05, 0.26, -5, peak=0.6),),) * 2,
        pelvis_yaw=Wave(0, 8, 10), pelvis_list=Wave(0, -3, 75), pelvis_tilt=Wave(3),
        torso_pitch=Wave(2, 0, 0, 3, 60), torso_yaw=Wave(0, -10, 60), torso_roll=Wave(0, 5, 90),
        head_roll=Wave(0, 4, 90), head_pitch=Wave(-3),
        arms=(Arm(Wave(12, -42, 60), Wave(20), Wave(8), Wave(55, -18, 60)),) * 2,
    ),
    Gait(  # walking in a slightly exaggerated manner
        "Sashay", frames=32, length=(0.60, 0.60), width=0.07, outward=0.035, toe_out=3,
        pelvis_yaw=Wave(0, 10, 10), pelvis_list=Wave(0, -8, 75),
        torso_yaw=Wave(0, -7, 10), torso_roll=Wave(0, 5, 75), torso_pitch=Wave(0, 0, 0, 1, 60),
        head_roll=Wave(0, -2, 75), head_pitch=Wave(-2),
        arms=(Arm(Wave(0, -20, 15), Wave(22, 4, 0), Wave(-25), Wave(42, -14, 30)),) * 2,
    ),
    Gait(  # slow walking with right leg hurt
        "Limp", kind="forceful", frames=57, length=(0.50, 0.40), share=(0.78, 1.22), width=0.15, double=0.28,
        strike=(4, 14), push=(16, 48), clearance=0.02, crouch=0.02, bob=0.035, surge=0.3,
        pelvis_list=Wave(0, -5, 60), pelvis_yaw=Wave(-4, 6, 10), pelvis_tilt=Wave(6),
        torso_pitch=Wave(15, 10, 40), torso_roll=Wave(3, 10, 70), torso_yaw=Wave(-4, -4, 10),
        head_pitch=Wave(14, 6, 40), head_roll=Wave(0, 3, 70),
        arms=(
            Arm(Wave(26, -4, 10), Wave(6), Wave(4), Wave(24)),
            Arm(Wave(4, -16, 10), Wave(24, -8, 60), Wave(10), Wave(42)),
        ),
    ),
    Gait(  # slow walking with arms akimbo
        "Pace", frames=51, length=(0.56, 0.56), double=0.26, bob=0.055, strike=(14, 14), push=(46, 46),
        pelvis_list=Wave(0, -4.5, 75), torso_yaw=Wave(0, -4, 10), torso_pitch=Wave(4), head_pitch=Wave(10),
        arms=(_AKIMBO, _AKIMBO),
    ),
    Gait(  # moving with very small steps
        "Penguin", frames=23, length=(0.24, 0.24), width=0.17, toe_out=28, strike=(0, 0), push=(9, 9), outward=0.01,
        clearance=0.035, bob=0.02, rise=0.75,
        pelvis_yaw=Wave(0, 10, 10), pelvis_list=Wave(0, 5, 90), pelvis_tilt=Wave(0),
        torso_roll=Wave(0, 10, 90), torso_yaw=Wave(0, 5, 10), torso_pitch=Wave(0), head_pitch=Wave(0),
        arms=(Arm(Wave(-8), Wave(30, 5, 90), Wave(-20), Wave(10)),) * 2,
    ),
    Gait(  # walking with shoulders moving aggressively
        "Strutting", frames=42, length=(0.68, 0.68), double=0.2, knee_out=5, toe_out=10,
        pelvis_yaw=Wave(0, 7, 10), pelvis_list=Wave(0, -4, 75),
        torso_yaw=Wave(0, -20, 5), torso_roll=Wave(0, 7, 60), torso_pitch=Wave(-6, 0, 0, 2, 60),
        head_yaw=Wave(0, 3, 5), head_pitch=Wave(-6),
        arms=(Arm(Wave(2, -26, 5), Wave(26, -6, 0), Wave(22), Wave(48, -16, 20)),) * 2,
    ),
    Gait(  # strut walking rhythmically
        "Joyful", frames=36, length=(0.62, 0.62), double=0.16, strike=(12, 12), push=(58, 58), surge=0.215, bob=0.06,
        kick=((Kick(0.0, 0.14, 8),), (Kick(0.0, 0.14, 8),)),
        pelvis_yaw=Wave(0, 7, 10), pelvis_list=Wave(0, -5, 75),
        torso_yaw=Wave(0, -11, 0), torso_roll=Wave(0, 6, 75), torso_pitch=Wave(2, 0, 0, 4, 30),
        head_pitch=Wave(-2, 0, 0, 6, 60), head_roll=Wave(0, 5, 75),
        arms=(Arm(Wave(14, -36, 5), Wave(26, 6, 180), Wave(4), Wave(62, -22, 10)),) * 2,
    ),
)  # fmt: skip

GAITS: dict[str, Gait] = {gait.name.lower(): gait for gait in (*_BASES, *_STYLES)}
"""Every gait by its name in lower case."""
