"""The numbers of the nominal arm: two equal axes; friction and inertia at the motor shaft."""

RATIO = 100.0

INERTIA = 1.289e-4              # rotor and wave generator [kg*m^2]
DRY = 0.037                     # [N*m]
VISCOUS = 5.96e-5               # [N*m*s/rad]
TORQUE_LIMIT = 0.3              # [N*m]
BRISTLE_STIFFNESS = DRY / 3e-4  # the bristles give way within one count of the encoder [N*m/rad]
BRISTLE_DAMPING = 0.08          # a third of critical on the rotor alone [N*m*s/rad]

PACE = 50.0                     # motor rate at which laws of friction are compared [rad/s]
K_P = 0.3                       # of the controller [N*m/rad], motor side
K_D = 0.012                     # [N*m*s/rad], motor side
TORQUE_NOISE = 1e-3             # one sigma, at the motor, each sample [N*m]

STIFFNESS = 9743.939            # flexspline, at zero torque [N*m/rad]
CURVATURE = 0.0831              # flexspline [1/(N*m)]
SOFT_TORQUE = RATIO / 27.027    # torque over which the wave generator saturates [N*m]
PSI = 2.0 / (RATIO * 27.027 * 2.5517)   # lost motion of the wave generator, both ways [rad]
DAMPING = 8.0                   # [N*m*s/rad]

LENGTH = 0.15                   # both links [m]
LINK_INERTIA = (0.876, 0.25, 0.18)      # [kg*m^2]
MASS_MOMENTS = (2.925, 1.2)     # [kg*m]
GRAVITY = 9.81                  # [m/s^2]

# One sigma, relative.
TOLERANCES = {'stiffness': 0.01, 'gain': 0.005, 'dry': 0.03, 'viscous': 0.10, 'damping': 0.10}
LINK_TOLERANCE = 0.01
TRUNCATION = 2.5                # in sigmas
LINK_ZERO = 1e-5                # one sigma of the link encoder's zero [rad]
