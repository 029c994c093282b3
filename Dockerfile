# ROS 2 Jazzy with this package:  docker build -t hda . && docker run --rm -it hda
FROM ros:jazzy-ros-base
WORKDIR /ws
COPY . src/hda_torque_estimator

# What has a rosdep key comes from Ubuntu; mcap (with lz4, zstandard) and pyarrow have none.
# RViz needs a screen: it is left out.
RUN apt-get update \
 && apt-get install -y --no-install-recommends python3-venv \
 && rosdep update --rosdistro jazzy \
 && rosdep install -y --rosdistro jazzy --from-paths src --ignore-src --dependency-types exec \
      --skip-keys rviz2 \
 && rm -rf /var/lib/apt/lists/* \
 && python3 -m venv --system-site-packages /opt/hda \
 && /opt/hda/bin/pip install --no-cache-dir mcap lz4 zstandard pyarrow

RUN . /opt/ros/jazzy/setup.sh \
 && /opt/hda/bin/python -m colcon build --packages-select hda_torque_estimator \
 && . install/setup.sh \
 && ros2 run hda_torque_estimator warm_up

ENTRYPOINT ["/bin/sh", "-c", ". /ws/install/setup.sh && exec \"$@\"", "--"]
CMD ["ros2", "run", "hda_torque_estimator", "hda", "--help"]
