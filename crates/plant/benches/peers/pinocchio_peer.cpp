// Pinocchio's articulated-body algorithm on our tree, behind a C interface. Header-only, double.
//
// The tree comes as JSON from `tree.rs`: each body with its parent, the place and the axis of its
// joint, mass, centre of mass and inertia tensor about it, all in the axes of the bicycle at rest.
// Every hinge becomes Pinocchio's cheapest one, about z, by turning the frame of the joint.

#include <Eigen/Geometry>
#include <boost/property_tree/json_parser.hpp>
#include <boost/property_tree/ptree.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/multibody.hpp>

#include <cstring>
#include <sstream>
#include <string>
#include <vector>

namespace {

using Tree = boost::property_tree::ptree;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using pinocchio::SE3;

struct Peer {
    pinocchio::Model model;
    pinocchio::Data data;
    Eigen::VectorXd q, v, tau;
    explicit Peer(pinocchio::Model &&built)
        : model(std::move(built)), data(model), q(pinocchio::Model::VectorXs::Zero(model.nq)),
          v(pinocchio::Model::VectorXs::Zero(model.nv)),
          tau(pinocchio::Model::VectorXs::Zero(model.nv)) {}
};

std::vector<double> numbers(const Tree &node, const char *key) {
    std::vector<double> out;
    for (const auto &entry : node.get_child(key)) out.push_back(entry.second.get_value<double>());
    return out;
}

Vector3d vector(const Tree &node, const char *key) {
    const auto n = numbers(node, key);
    return Vector3d(n.at(0), n.at(1), n.at(2));
}

pinocchio::Model build(const Tree &tree) {
    pinocchio::Model model;
    model.gravity.linear() = Vector3d(0, 0, tree.get<double>("gravity_m_s2"));
    // Joint of each body, and how the axes of its joint frame stand in those of the bicycle.
    std::vector<pinocchio::JointIndex> joints;
    std::vector<Matrix3d> turned;
    std::vector<Vector3d> origins;
    for (const auto &entry : tree.get_child("bodies")) {
        const Tree &body = entry.second;
        const std::string kind = body.get<std::string>("joint");
        const int parent = body.get<int>("parent");
        const Vector3d at = vector(body, "joint_at_m");
        Matrix3d axes = Matrix3d::Identity();
        if (kind == "hinge")
            axes = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), vector(body, "axis"))
                       .toRotationMatrix();
        SE3 placement = SE3::Identity();
        pinocchio::JointIndex above = 0;
        if (parent >= 0) {
            above = joints.at(parent);
            const Matrix3d &frame = turned.at(parent);
            placement = SE3(frame.transpose() * axes, frame.transpose() * (at - origins.at(parent)));
        }
        pinocchio::JointIndex id;
        const std::string name = body.get<std::string>("name");
        if (kind == "free")
            id = model.addJoint(above, pinocchio::JointModelFreeFlyer(), placement, name);
        else if (kind == "ball")
            id = model.addJoint(above, pinocchio::JointModelSpherical(), placement, name);
        else
            id = model.addJoint(above, pinocchio::JointModelRZ(), placement, name);
        const auto t = numbers(body, "tensor_kg_m2"); // xx, yy, zz, xy, xz, yz
        Matrix3d tensor;
        tensor << t[0], t[3], t[4], t[3], t[1], t[5], t[4], t[5], t[2];
        const pinocchio::Inertia inertia(body.get<double>("mass_kg"),
                                         axes.transpose() * (vector(body, "centre_m") - at),
                                         axes.transpose() * tensor * axes);
        model.appendBodyToJoint(id, inertia, SE3::Identity());
        joints.push_back(id);
        turned.push_back(axes);
        origins.push_back(at);
    }
    return model;
}

} // namespace

extern "C" {

// A model from JSON; null and a message where that fails.
void *pinocchio_build(const char *json, char *error, int size) {
    try {
        std::istringstream in(json);
        Tree tree;
        boost::property_tree::read_json(in, tree);
        return new Peer(build(tree));
    } catch (const std::exception &e) {
        std::strncpy(error, e.what(), size - 1);
        error[size - 1] = 0;
        return nullptr;
    }
}

int pinocchio_positions(const void *peer) { return static_cast<const Peer *>(peer)->model.nq; }
int pinocchio_velocities(const void *peer) { return static_cast<const Peer *>(peer)->model.nv; }

void pinocchio_state(void *peer, const double *q, const double *v, const double *tau) {
    auto &p = *static_cast<Peer *>(peer);
    p.q = Eigen::Map<const Eigen::VectorXd>(q, p.model.nq);
    p.v = Eigen::Map<const Eigen::VectorXd>(v, p.model.nv);
    p.tau = Eigen::Map<const Eigen::VectorXd>(tau, p.model.nv);
}

// `count` times bare `aba` in its fastest convention.
void pinocchio_aba(void *peer, long count) {
    auto &p = *static_cast<Peer *>(peer);
    for (long k = 0; k < count; ++k)
        pinocchio::aba(p.model, p.data, p.q, p.v, p.tau, pinocchio::Convention::LOCAL);
}

// The same in the convention that is the library's default.
void pinocchio_aba_world(void *peer, long count) {
    auto &p = *static_cast<Peer *>(peer);
    for (long k = 0; k < count; ++k)
        pinocchio::aba(p.model, p.data, p.q, p.v, p.tau, pinocchio::Convention::WORLD);
}

void pinocchio_accelerations(const void *peer, double *out) {
    const auto &p = *static_cast<const Peer *>(peer);
    Eigen::Map<Eigen::VectorXd>(out, p.model.nv) = p.data.ddq;
}

const char *pinocchio_version() { return PINOCCHIO_VERSION; }
}
