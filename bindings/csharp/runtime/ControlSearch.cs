using System;
using System.Collections.Generic;

namespace FaceBaker
{
    /// <summary>Controls by group and by what somebody types, for panels of sliders, and by names of both.</summary>
    public static class ControlSearch
    {
        /// <summary>The controls whose name, group, ARKit or FACS name contains the text, in any case ("": all), by group:
        /// groups and controls in the order of the face.</summary>
        public static List<KeyValuePair<string, List<Control>>> ByGroup(IReadOnlyList<Control> controls, string text)
        {
            var groups = new List<KeyValuePair<string, List<Control>>>();
            var places = new Dictionary<string, int>();
            foreach (Control control in controls)
            {
                if (!Has(control.Name, text) && !Has(control.Group, text) && !Has(control.ArKit, text) &&
                    !Has(control.Facs, text))
                    continue;
                int place;
                if (!places.TryGetValue(control.Group, out place))
                {
                    place = groups.Count;
                    places.Add(control.Group, place);
                    groups.Add(new KeyValuePair<string, List<Control>>(control.Group, new List<Control>()));
                }
                groups[place].Value.Add(control);
            }
            return groups;
        }

        /// <summary>One a control, true for those that are named: by their own name or that of their control group, or else by
        /// their ARKit or FACS name. See <see cref="SolveTargets.Movable"/>.</summary>
        /// <exception cref="FaceBakerException">There is neither; the message has the closest name of a control.</exception>
        public static bool[] MaskOf(Face face, params string[] names)
        {
            return Mask(face, names, true);
        }

        /// <summary>One a control, false for those that are named, as by <see cref="MaskOf"/>.</summary>
        /// <exception cref="FaceBakerException">There is neither; the message has the closest name of a control.</exception>
        public static bool[] MaskWithout(Face face, params string[] names)
        {
            return Mask(face, names, false);
        }

        private static bool[] Mask(Face face, string[] names, bool named)
        {
            var mask = new bool[face.ControlCount];
            if (!named) Array.Fill(mask, true);
            foreach (string name in names)
            {
                bool found = false;
                foreach (Control control in face.Controls)
                {
                    if (name == "" || control.Name != name && control.Group != name) continue;
                    mask[control.Index] = named;
                    found = true;
                }
                if (!found) mask[face.FindControl(name)] = named; // by its other names, or a message with the closest one
            }
            return mask;
        }

        private static bool Has(string where, string text)
        {
            return where.IndexOf(text, StringComparison.OrdinalIgnoreCase) >= 0;
        }
    }
}
