// Three kinds of lamps, and what each of them adds to a surface's colour.
#include "lib/attenuation.glsl"
#include "lib/reflection.glsl"
#include "lib/spotlight.glsl"

struct Surface {
    vec3 place;
    vec3 normal;      // of unit length
    vec3 viewDir;     // of unit length, towards the viewer
    vec3 diffuse;     // also its ambient colour
    vec3 specular;
    float shininess;
};

struct DirLight {
    vec3 direction;   // the way its light travels
    vec3 ambient;
    vec3 diffuse;
    vec3 specular;
};

struct PointLight {
    vec3 position;
    float constant;
    float linear;
    float quadratic;
    vec3 ambient;
    vec3 diffuse;
    vec3 specular;
};

struct SpotLight {
    vec3 position;
    vec3 direction;
    float cutOff;        // cosine of the inner cone's half angle
    float outerCutOff;   // cosine of the outer cone's half angle
    float constant;
    float linear;
    float quadratic;
    vec3 ambient;
    vec3 diffuse;
    vec3 specular;
};

// The part that has a direction: diffuse and specular.
vec3 directed(Surface surface, vec3 lightDir, vec3 diffuse, vec3 specular)
{
    float diff = diffuseFactor(surface.normal, lightDir);
    float spec = phongLobe(surface.normal, lightDir, surface.viewDir, surface.shininess);
    return diffuse * (diff * surface.diffuse) + specular * (spec * surface.specular);
}

// From so far away that all rays are parallel and none has faded.
vec3 CalcDirLight(DirLight light, Surface surface)
{
    vec3 lightDir = normalize(-light.direction);
    return light.ambient * surface.diffuse
         + directed(surface, lightDir, light.diffuse, light.specular);
}

// In all directions from one place, fading on the way.
vec3 CalcPointLight(PointLight light, Surface surface)
{
    vec3 ray = light.position - surface.place;
    Attenuation fading = Attenuation(light.constant, light.linear, light.quadratic);
    vec3 part = directed(surface, normalize(ray), light.diffuse, light.specular);
    return attenuationAt(fading, length(ray)) * (light.ambient * surface.diffuse + part);
}

// A point light that shines into a cone with a soft edge. The notes only have a call of it, in a
// comment: what it does is written here.
vec3 CalcSpotLight(SpotLight light, Surface surface)
{
    vec3 ray = light.position - surface.place;
    Attenuation fading = Attenuation(light.constant, light.linear, light.quadratic);
    Spot cone = Spot(light.position, light.direction, light.cutOff, light.outerCutOff);
    vec3 part = directed(surface, normalize(ray), light.diffuse, light.specular);
    part *= spotIntensity(cone, surface.place);
    return attenuationAt(fading, length(ray)) * (light.ambient * surface.diffuse + part);
}
